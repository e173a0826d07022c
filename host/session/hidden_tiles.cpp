#include "host/session/hidden_tiles.h"

#include <algorithm>
#include <cmath>

#include "host/splats/raster.h"

namespace knead {
namespace {

using Corner = std::array<float, 2>;  // [pixels], from the upper left corner

// Marks the pixels whose middles lie in the triangle.
void mark(std::vector<char>& pixels, int width, int height, const Corner (&c)[3])
{
    const auto span = [&](std::size_t axis, int end) {
        const float low = std::min({c[0][axis], c[1][axis], c[2][axis]});
        const float high = std::max({c[0][axis], c[1][axis], c[2][axis]});
        const auto pixel = [end](float at) { return int(clamp(at, 0.0f, float(end))); };
        return std::array<int, 2>{pixel(std::floor(low)), pixel(std::ceil(high))};
    };
    const auto x = span(0, width), y = span(1, height);
    for (int j = y[0]; j < y[1]; ++j)
        for (int i = x[0]; i < x[1]; ++i) {
            int left = 0, right = 0;
            for (int k = 0; k < 3; ++k) {
                const Corner &a = c[k], &b = c[(k + 1) % 3];
                const float side = (b[0] - a[0]) * (float(j) + 0.5f - a[1]) -
                                   (b[1] - a[1]) * (float(i) + 0.5f - a[0]);
                left += side >= 0, right += side <= 0;
            }
            if (left == 3 || right == 3) pixels[std::size_t(j) * std::size_t(width) + i] = 1;
        }
}

}  // namespace

void HiddenTiles::set(const std::vector<std::array<float, 2>>& corners)
{
    if (corners == corners_) return;
    corners_ = corners;
    view_ = {};
}

const std::vector<char>& HiddenTiles::of(const EyeView& view)
{
    const EyeView& v = view;
    if (v.width == view_.width && v.height == view_.height && v.left == view_.left &&
        v.right == view_.right && v.down == view_.down && v.up == view_.up)
        return tiles_;
    view_ = view;
    tiles_.clear();
    if (corners_.empty()) return tiles_;
    std::vector<char> pixels(std::size_t(v.width) * std::size_t(v.height), 0);
    const float across = float(v.width) / (v.right - v.left);
    const float along = float(v.height) / (v.up - v.down);
    for (std::size_t t = 0; t + 2 < corners_.size(); t += 3) {
        Corner c[3];
        for (std::size_t k = 0; k < 3; ++k)
            c[k] = {(corners_[t + k][0] - v.left) * across, (v.up - corners_[t + k][1]) * along};
        mark(pixels, v.width, v.height, c);
    }
    const int columns = (v.width + hidden_tile - 1) / hidden_tile;
    const int rows = (v.height + hidden_tile - 1) / hidden_tile;
    tiles_.assign(std::size_t(columns) * std::size_t(rows), 1);
    // A pixel that is seen shows the tiles of all its neighbours.
    for (int y = 0; y < v.height; ++y)
        for (int x = 0; x < v.width; ++x) {
            if (pixels[std::size_t(y) * std::size_t(v.width) + std::size_t(x)]) continue;
            for (const int j : {std::max(0, y - 1), std::min(v.height - 1, y + 1)})
                for (const int i : {std::max(0, x - 1), std::min(v.width - 1, x + 1)})
                    tiles_[std::size_t(j / hidden_tile) * std::size_t(columns) +
                           std::size_t(i / hidden_tile)] = 0;
        }
    return tiles_;
}

}  // namespace knead
