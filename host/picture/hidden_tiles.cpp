#include "host/picture/hidden_tiles.h"

#include <algorithm>
#include <cmath>

#include "host/splats/raster.h"

namespace knead {
namespace {

using Corner = std::array<float, 2>;  // [pixels], from the upper left corner

// Marks the pixels whose centres lie in the triangle, row by row between two of its sides.
void mark(std::vector<char>& pixels, int width, int height, const Corner (&c)[3])
{
    const auto span = [&](std::size_t axis, int end) {
        const float low = std::min({c[0][axis], c[1][axis], c[2][axis]});
        const float high = std::max({c[0][axis], c[1][axis], c[2][axis]});
        const auto pixel = [end](float at) { return int(clamp(at, 0.0f, float(end))); };
        return std::array<int, 2>{pixel(std::floor(low)), pixel(std::ceil(high))};
    };
    const auto side = [](const Corner& a, const Corner& b, float x, float y) {
        return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
    };
    const float way_round = side(c[0], c[1], c[2][0], c[2][1]) < 0 ? -1 : 1;
    const auto across = span(0, width), along = span(1, height);
    for (int j = along[0]; j < along[1]; ++j) {
        int from = across[0], to = across[1];
        for (std::size_t k = 0; k < 3 && from < to; ++k) {
            const auto inside = [&](int i) {
                return way_round * side(c[k], c[(k + 1) % 3], float(i) + 0.5f, float(j) + 0.5f) >=
                       0;
            };
            const auto first = [&](bool such) {  // bisection: inside() changes at most once
                int low = from, high = to;
                while (low < high) {
                    const int middle = low + (high - low) / 2;
                    (inside(middle) == such ? high : low) = middle + (inside(middle) != such);
                }
                return low;
            };
            if (!inside(from))
                from = first(true);
            else
                to = first(false);
        }
        if (from < to)
            std::fill_n(pixels.begin() + std::ptrdiff_t(j) * width + from, to - from, char(1));
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
    pixels_.assign(std::size_t(v.width) * std::size_t(v.height), 0);
    const float across = float(v.width) / (v.right - v.left);
    const float along = float(v.height) / (v.up - v.down);
    for (std::size_t t = 0; t + 2 < corners_.size(); t += 3) {
        Corner c[3];
        for (std::size_t k = 0; k < 3; ++k)
            c[k] = {(corners_[t + k][0] - v.left) * across, (v.up - corners_[t + k][1]) * along};
        mark(pixels_, v.width, v.height, c);
    }
    // A visible pixel keeps the tiles of all its neighbours visible.
    const int columns = (v.width + hidden_tile - 1) / hidden_tile;
    const int rows = (v.height + hidden_tile - 1) / hidden_tile;
    const auto shown = [&](int tile, int end) {
        return std::array<int, 2>{std::max(0, tile * hidden_tile - 1),
                                  std::min(end, (tile + 1) * hidden_tile + 1)};
    };
    for (int row = 0; row < rows; ++row)
        for (int column = 0; column < columns; ++column) {
            const auto x = shown(column, v.width), y = shown(row, v.height);
            bool all = true;
            for (int j = y[0]; j < y[1] && all; ++j) {
                const auto at = pixels_.begin() + std::ptrdiff_t(j) * v.width;
                all = std::find(at + x[0], at + x[1], char(0)) == at + x[1];
            }
            tiles_.push_back(char(all));
        }
    return tiles_;
}

}  // namespace knead
