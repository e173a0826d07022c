#include "host/session/splat_layer.h"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace knead {
namespace {

// Depths beside those that are there, so many pixels far; behind that, the mean of all.
void spread(SplatLayer& layer, int far)
{
    double sum = 0;
    long count = 0;
    for (const float d : layer.depth)
        if (d < no_depth) sum += double(d), ++count;
    if (count == 0) return;
    for (int round = 0; round < far; ++round) {
        const std::vector<float> before = layer.depth;
        const auto at = [&](int x, int y) {
            return before[std::size_t(y) * std::size_t(layer.width) + std::size_t(x)];
        };
        for (int y = 0; y < layer.height; ++y)
            for (int x = 0; x < layer.width; ++x) {
                float& d = layer.depth[std::size_t(y) * std::size_t(layer.width) + std::size_t(x)];
                if (d < no_depth) continue;
                for (const int i : {-1, 1}) {
                    if (x + i >= 0 && x + i < layer.width) d = std::min(d, at(x + i, y));
                    if (y + i >= 0 && y + i < layer.height) d = std::min(d, at(x, y + i));
                }
            }
    }
    const float mean = float(sum / double(count));
    for (std::size_t i = 0; i < layer.depth.size(); ++i)
        if (!(layer.depth[i] < no_depth) && layer.colour[4 * i + 3] > 0) layer.depth[i] = mean;
}

}  // namespace

SplatLayer layer_of(const Picture& picture)
{
    SplatLayer layer{picture.width, picture.height, {}, picture.depth};
    layer.colour.resize(4 * picture.pixels());
    for (std::size_t i = 0; i < picture.pixels(); ++i) {
        const Vec3<float> c = picture.colour[i];
        const float values[4] = {c.x, c.y, c.z, picture.alpha[i]};
        std::copy(values, values + 4, layer.colour.begin() + std::ptrdiff_t(4 * i));
    }
    spread(layer, 3);
    return layer;
}

SplatDrawer::SplatDrawer(const SplatCloud& cloud, Device device, double budget)
    : device_(resolved(device)), pace_(budget, 0.125, 0.5)
{
    set(cloud);
}

void SplatDrawer::set(const SplatCloud& cloud)
{
    antialiased_ = cloud.antialiased;
    if (device_.kind == DeviceKind::cuda)
        gpu_ = std::make_unique<GpuRaster>(cloud, 0, device_.index);
    else
        cloud_ = cloud;
}

SplatLayer SplatDrawer::layer(const EyeView& view, const std::vector<Gaussian<double>>& gaussians,
                              bool whole, HiddenTiles* hidden)
{
    using Clock = std::chrono::steady_clock;
    scale_ = whole ? 1 : pace_.scale();
    EyeView coarse = view;
    coarse.width = std::max(1, int(std::lround(scale_ * view.width)));
    coarse.height = std::max(1, int(std::lround(scale_ * view.height)));
    SplatFrame frame;
    frame.eyes = {splat_eye(coarse)};
    frame.rule.antialiased = antialiased_;
    if (hidden && !gpu_) frame.hidden = {hidden->of(coarse)};
    for (const Gaussian<double>& g : gaussians) {
        frame.moved_centre.push_back(cast<float>(g.x));
        frame.moved_F.push_back({cast<float>(g.F.a), cast<float>(g.F.b), cast<float>(g.F.c)});
    }
    const Clock::time_point begin = Clock::now();
    const SplatLayer made =
        layer_of(gpu_ ? gpu_->pictures(frame).front() : cpu_raster(cloud_, frame).front());
    seconds_ = std::chrono::duration<double>(Clock::now() - begin).count();
    if (!whole) pace_.took(seconds_);
    return made;
}

}  // namespace knead
