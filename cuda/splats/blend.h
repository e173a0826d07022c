// One pixel, splat by splat from the nearest on: the over operator, until nothing shines through.
// [Porter 1984] [Kerbl 2023]
#pragma once
#include "cuda/splats/footprint.h"

namespace knead {

constexpr double min_transmittance = 1e-4;    // less is nothing
constexpr double median_transmittance = 0.5;  // where the splats' depth is taken
constexpr double mesh_slack = 1.02;  // how far behind the mesh a centre ends a pixel: order is by
                                     // centres, and a nearer part may follow
constexpr float no_depth = 1e30f;    // [m]: of a pixel in which there is nothing

template <class R>
struct Pixel {
    Vec3<R> colour{0, 0, 0};  // premultiplied
    R transmittance = 1;
    R depth = R(no_depth);
    bool done = false;
};

// alpha at (x, y) of the screen; 0 where it is less than min_alpha.
template <class R>
HD R alpha_at(const Footprint<R>& f, R x, R y)
{
    const R dx = x - f.u, dy = y - f.v;
    const R power = f.peak - f.a * dx * dx - dy * (f.b * dx + f.c * dy);
    if (!(power >= R(log2_min_alpha))) return 0;
    return min(fast_exp2(power), R(max_alpha));
}

// Adds a splat of this alpha and colour; depth() answers with its depth at the pixel [m].
template <class R, class Depth>
HD void add(Pixel<R>& p, R alpha, Vec3<R> colour, Depth&& depth)
{
    const R before = p.transmittance, weight = alpha * before;
    p.colour = p.colour + weight * colour;
    p.transmittance = before - weight;
    if (before >= R(median_transmittance) && p.transmittance < R(median_transmittance))
        p.depth = depth();
    if (p.transmittance < R(min_transmittance)) p.done = true;
}

template <class R>
HD R depth_at(const Footprint<R>& f, R x, R y)
{
    return f.depth + f.gx * (x - f.u) + f.gy * (y - f.v);
}

// Adds what the splat shows at (x, y).
template <class R>
HD void blend(Pixel<R>& p, const Footprint<R>& f, Vec3<R> colour, R x, R y)
{
    const R alpha = alpha_at(f, x, y);
    if (alpha > 0) add(p, alpha, colour, [&] { return depth_at(f, x, y); });
}

// The same with a mesh at depth `mesh` [m]: what lies behind it is not seen.
template <class R>
HD void blend(Pixel<R>& p, const Footprint<R>& f, Vec3<R> colour, R x, R y, R mesh)
{
    const R alpha = alpha_at(f, x, y), depth = depth_at(f, x, y);
    if (!(alpha > 0)) return;
    if (depth <= mesh)
        add(p, alpha, colour, [depth] { return depth; });
    else if (f.depth > R(mesh_slack) * mesh)
        p.done = true;
}

// Once all splats are through: what the mesh, or the background, adds. A mesh has alpha 1 and is
// what lies at this depth where the splats let half of it through.
template <class R>
HD void finish(Pixel<R>& p, Vec3<R> behind, R alpha_behind, R mesh)
{
    p.colour = p.colour + p.transmittance * behind;
    if (p.transmittance >= R(median_transmittance)) p.depth = min(mesh, R(no_depth));
    p.transmittance = p.transmittance * (1 - alpha_behind);
}

}  // namespace knead
