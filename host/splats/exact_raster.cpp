// The reference: every splat in every pixel.
#include <algorithm>

#include "host/base/parallel.h"
#include "host/splats/cancellable_for.h"
#include "host/splats/prepared.h"

namespace knead {
namespace {

struct SeenExactly {
    Footprint<double> shape;
    Vec3<double> colour;
    double key;  // sort key, unless the order is per pixel
};

// Returns false if the frame was stopped.
bool find_seen_exactly(const Eye<double>& eye, const SplatCloud& cloud, const SplatFrame& frame,
                       DepthOrder order, std::vector<SeenExactly>& seen)
{
    const Pinhole<double> c = pinhole(eye);
    const SplatOptions<double> options = cast<double>(frame.options);
    const Vec3<double> from = order == DepthOrder::middle ? middle_of(frame) : eye.position;
    const auto see = [&](std::size_t i) {
        const PosedSplat<double> p = posed<double>(cloud, frame, i);
        SeenExactly s;
        if (!project(c, options, p.centre, p.half_axes, double(cloud.opacity[i]), s.shape)) return;
        s.colour = colour_from(eye.position, p, cloud, i);
        s.key = order == DepthOrder::plane ? s.shape.depth : length(p.centre - from);
        seen.push_back(s);
    };
    const auto nearer = [](const SeenExactly& a, const SeenExactly& b) { return a.key < b.key; };
    return for_each_unless_stopped(cloud.count(), frame, see) &&
           (order == DepthOrder::pixel || sort_unless_stopped(seen, frame, nearer));
}

struct Touch {
    double depth, alpha;
    Vec3<double> colour;
};

// Collects all splats drawn at (x, y) in front of the mesh, nearest first.
void touches(const std::vector<SeenExactly>& seen, double x, double y, double mesh, bool by_pixel,
             std::vector<Touch>& all)
{
    all.clear();
    for (const SeenExactly& s : seen) {
        const Footprint<double>& f = s.shape;
        const double alpha = alpha_at(f, x, y);
        if (alpha == 0) continue;
        const double depth = depth_at(f, x, y);
        if (depth <= mesh) all.push_back({depth, alpha, s.colour});
    }
    if (by_pixel)
        std::stable_sort(all.begin(), all.end(),
                         [](const Touch& a, const Touch& b) { return a.depth < b.depth; });
}

bool draw_exactly(std::size_t e, const std::vector<SeenExactly>& seen, const SplatFrame& frame,
                  DepthOrder order, Picture& picture)
{
    const int width = frame.eyes[e].width, height = frame.eyes[e].height;
    if (!resize_unless_stopped(picture, frame.eyes[e], frame)) return false;
    const bool has_mesh = !frame.behind.empty() && !frame.behind[e].depth.empty();
    parallel_for(height, LoopOptions{.chunk = 1}, [&](int y) {
        std::vector<Touch> all;
        for (int x = 0; x < width && !frame.stopped(); ++x) {
            const std::size_t at = std::size_t(y) * std::size_t(width) + std::size_t(x);
            const float depth = has_mesh ? frame.behind[e].depth[at] : no_depth;
            const bool hit = depth < no_depth;
            touches(seen, x, y, double(depth), order == DepthOrder::pixel, all);
            Pixel<double> p;
            for (const Touch& t : all) add(p, t.alpha, t.colour, t.depth);
            finish(p, cast<double>(hit ? frame.behind[e].colour[at] : frame.background),
                   hit ? 1.0 : 0.0, double(depth));
            picture.colour[at] = cast<float>(p.colour);
            picture.alpha[at] = float(1 - p.transmittance);
            picture.depth[at] = float(p.depth);
        }
    });
    return !frame.stopped();
}

}  // namespace

std::vector<Picture> exact_raster(const SplatCloud& cloud, const SplatFrame& frame,
                                  DepthOrder order)
{
    check_frame(cloud, frame);
    std::vector<Picture> pictures(frame.eyes.size());
    for (std::size_t e = 0; e < frame.eyes.size(); ++e) {
        std::vector<SeenExactly> seen;
        if (!find_seen_exactly(cast<double>(frame.eyes[e]), cloud, frame, order, seen) ||
            !draw_exactly(e, seen, frame, order, pictures[e]))
            return {};
    }
    return pictures;
}

}  // namespace knead
