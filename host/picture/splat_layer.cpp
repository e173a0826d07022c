#include "host/picture/splat_layer.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "cuda/splats/extrapolate.h"
#include "cuda/splats/spread.h"
#include "host/base/machine.h"

namespace knead {
namespace {

// The same as on the device (cuda/splats/spread.cu).
void spread(SplatLayer& layer)
{
    DepthSum sum{0, 0};
    for (const float d : layer.depth)
        if (d < no_depth) sum.units += counted_depth(d), ++sum.pixels;
    for (int round = 0; round < spread_rounds; ++round) {
        const std::vector<float> before = layer.depth;
        const auto at = [&](int x, int y) {
            const bool inside = x >= 0 && x < layer.width && y >= 0 && y < layer.height;
            return inside ? before[std::size_t(y) * std::size_t(layer.width) + std::size_t(x)]
                          : no_depth;
        };
        std::size_t i = 0;
        for (int y = 0; y < layer.height; ++y)
            for (int x = 0; x < layer.width; ++x, ++i)
                layer.depth[i] =
                    spread_depth(before[i], at(x - 1, y), at(x + 1, y), at(x, y - 1), at(x, y + 1));
    }
    for (std::size_t i = 0; i < layer.depth.size(); ++i)
        layer.depth[i] = filled_depth(layer.depth[i], layer.colour[4 * i + 3] > 0, sum);
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
    spread(layer);
    return layer;
}

SplatDrawer::SplatDrawer(const SplatCloud& cloud, Device device, double budget)
    : device_(resolved(device)), budget_(budget), pace_(budget, 0.125, 0.5)
{
    set(cloud);
}

void SplatDrawer::set(const SplatCloud& cloud)
{
    coming_ = {}, coming_cloud_ = nullptr;  // waits for the thread that uses the rasteriser
    antialiased_ = cloud.antialiased;
    if (device_.kind == DeviceKind::cuda)
        gpu_ = raster_of(cloud, 0);
    else
        cloud_ = cloud;
}

// Reserves a quarter more for splats that are split or added.
std::unique_ptr<GpuRaster> SplatDrawer::raster_of(const SplatCloud& cloud,
                                                  std::size_t instances) const
{
    auto made = std::make_unique<GpuRaster>(cloud, 0, device_.index, cloud.count() / 4 * 5);
    made->reserve(instances);
    return made;
}

void SplatDrawer::prepare(std::shared_ptr<const SplatCloud> cloud)
{
    coming_cloud_ = std::move(cloud);
    if (device_.kind != DeviceKind::cuda) return;
    coming_ = std::async(std::launch::async,
                         [this, cloud = coming_cloud_, to = gpu_.get(), room = gpu_->room()] {
                             if (!to->serves(*cloud)) return raster_of(*cloud, room);
                             to->prepare(*cloud);
                             return std::unique_ptr<GpuRaster>();
                         });
}

bool SplatDrawer::adopt()
{
    using namespace std::chrono_literals;
    if (!preparing()) return false;
    if (coming_.valid() && coming_.wait_for(0s) != std::future_status::ready) return false;
    const std::shared_ptr<const SplatCloud> cloud = std::exchange(coming_cloud_, nullptr);
    if (!coming_.valid()) return set(*cloud), true;
    antialiased_ = cloud->antialiased;
    std::unique_ptr<GpuRaster> made = coming_.get();
    if (!made) return gpu_->show_prepared(), true;
    std::unique_ptr<GpuRaster> before = std::exchange(gpu_, std::move(made));
    going_ = std::async(std::launch::async, [old = std::move(before)]() mutable { old.reset(); });
    return true;
}

// `hidden`: one per view; null: none.
SplatFrame SplatDrawer::frame_of(const std::vector<EyeView>& views, const SplatMotion& motion,
                                 HiddenTiles* hidden) const
{
    SplatFrame frame;
    for (std::size_t eye = 0; eye < views.size(); ++eye) {
        EyeView view = views[eye];
        view.width = std::max(1, int(std::lround(scale_ * view.width)));
        view.height = std::max(1, int(std::lround(scale_ * view.height)));
        frame.eyes.push_back(splat_eye(view));
        if (hidden) frame.hidden.push_back(hidden[eye].of(view));
    }
    frame.fovea.assign(frame.eyes.size(), fovea_);
    frame.options.antialiased = antialiased_;
    frame.extrapolation = motion.extrapolation;
    if (!motion.host) return frame;
    const bool goes_on = motion.host_before && motion.host_before->size() == motion.host->size();
    for (std::size_t i = 0; i < motion.host->size(); ++i) {
        const Gaussian<double>& now = (*motion.host)[i];
        const Gaussian<double>& before = goes_on ? (*motion.host_before)[i] : now;
        const double extrapolation = double(motion.extrapolation);
        const Mat3<double> F = extrapolated(now.F, before.F, extrapolation);
        frame.moved_centre.push_back(cast<float>(extrapolated(now.x, before.x, extrapolation)));
        frame.moved_F.push_back({cast<float>(F.a), cast<float>(F.b), cast<float>(F.c)});
    }
    return frame;
}

SplatLayer SplatDrawer::layer(const EyeView& view, const SplatMotion& motion, bool full_resolution,
                              HiddenTiles* hidden)
{
    scale_ = full_resolution ? 1 : pace_.scale();
    SplatFrame frame = frame_of({view}, motion, hidden);
    if (motion.device) motion.device->fetch(frame);
    const double begin = wall_seconds();
    SplatLayer made =
        layer_of(gpu_ ? gpu_->pictures(frame).front() : cpu_raster(cloud_, frame).front());
    seconds_ = wall_seconds() - begin;
    if (!full_resolution) pace_.took(seconds_);
    return made;
}

void SplatDrawer::draw(EyePainter& painter, const std::vector<EyeView>& views,
                       const SplatMotion& motion, bool full_resolution,
                       std::array<HiddenTiles, 2>* hidden)
{
    const auto same_size = [&](const EyeView& v) {
        return v.width == views[0].width && v.height == views[0].height;
    };
    if (gpu_ && painter.sharing(gpu_->device()).shared &&
        std::all_of(views.begin(), views.end(), same_size)) {
        // Nothing is copied to the host: starts at full resolution, reduced if it proves too slow.
        if (!shared_) pace_ = Pace(budget_ * double(views.size()), 0.125, 1);
        shared_ = true;
        scale_ = full_resolution ? 1 : pace_.scale();
        painter.set_splats(*gpu_, frame_of(views, motion, hidden ? hidden->data() : nullptr),
                           motion.device);
        seconds_ = painter.splat_seconds();
        if (!full_resolution && seconds_ > 0) pace_.took(seconds_);
        return;
    }
    for (std::size_t eye = 0; eye < views.size(); ++eye)
        painter.set_splats(int(eye), layer(views[eye], motion, full_resolution,
                                           hidden ? &hidden->at(eye) : nullptr));
}

}  // namespace knead
