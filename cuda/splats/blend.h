// One pixel: splats are blended front to back by the over operator, until the pixel is opaque.
// [Porter 1984] [Kerbl 2023]
#pragma once
#include "cuda/splats/footprint.h"

namespace knead {

constexpr double min_transmittance = 1e-4;    // less counts as 0
constexpr double median_transmittance = 0.5;  // at which the depth of the splats is taken
// Blending of a pixel ends at the first splat whose centre is deeper than the mesh by this factor.
// The margin is needed because splats are sorted by their centres, and a later splat may extend in
// front of its own centre.
constexpr double mesh_slack = 1.02;
constexpr float no_depth = 1e30f;  // [m]: of an empty pixel

template <class R>
struct Pixel {
    Vec3<R> colour{0, 0, 0};  // premultiplied
    R transmittance = 1;      // of all splats so far; 0: done
    R held = 0;               // transmittance at which the mesh ended the blending
    R depth = R(no_depth);    // of the last splat at transmittance >= 1/2 [m]
};

template <class R>
HD bool done(const Pixel<R>& p)
{
    return p.transmittance == 0;
}

// log2 of alpha at (x, y) of the screen; valid if drawn() of it is true.
template <class R>
HD R power_at(const Footprint<R>& f, R x, R y)
{
    const R dx = x - f.u, dy = y - f.v;
    const R of_x = fast_fma(-f.a * dx, dx, f.peak);
    return fast_fma(-dy, fast_fma(f.c, dy, f.b * dx), of_x);
}
template <class R>
HD bool drawn(R power)
{
    return power >= R(log2_min_alpha);
}
template <class R>
HD R alpha_of(R power)
{
    return min(fast_exp2(power), R(max_alpha));
}
// alpha at (x, y); 0 below min_alpha.
template <class R>
HD R alpha_at(const Footprint<R>& f, R x, R y)
{
    const R power = power_at(f, x, y);
    return drawn(power) ? alpha_of(power) : R(0);
}

template <class R>
HD R depth_at(const Footprint<R>& f, R x, R y)
{
    return f.depth + f.gx * (x - f.u) + f.gy * (y - f.v);
}

// Adds a splat of this alpha and colour.
template <class R>
HD void add(Pixel<R>& p, R alpha, Vec3<R> colour)
{
    const R weight = alpha * p.transmittance;
    const R left = fast_fma(-alpha, p.transmittance, p.transmittance);
    p.colour = {fast_fma(weight, colour.x, p.colour.x), fast_fma(weight, colour.y, p.colour.y),
                fast_fma(weight, colour.z, p.colour.z)};
    p.transmittance = left >= R(min_transmittance) ? left : R(0);
}

// Whether the pixel's depth may still change.
template <class R>
HD bool takes_depth(const Pixel<R>& p)
{
    return p.transmittance >= R(median_transmittance);
}

// The same with the splat's depth at the pixel [m].
template <class R>
HD void add(Pixel<R>& p, R alpha, Vec3<R> colour, R depth)
{
    if (takes_depth(p)) p.depth = depth;
    add(p, alpha, colour);
}

// Blends the splat at (x, y). A splat that is not drawn is added with alpha 0, without effect: on a
// GPU a select is faster than a branch.
template <class R>
HD void blend(Pixel<R>& p, const Footprint<R>& f, Vec3<R> colour, R x, R y)
{
    const R power = power_at(f, x, y), alpha = alpha_of(power), depth = depth_at(f, x, y);
    p.depth = drawn(power) && takes_depth(p) ? depth : p.depth;
    add(p, drawn(power) ? alpha : R(0), colour);
}

// The same where takes_depth() is false.
template <class R>
HD void blend_deep(Pixel<R>& p, const Footprint<R>& f, Vec3<R> colour, R x, R y)
{
    const R power = power_at(f, x, y), alpha = alpha_of(power);
    add(p, drawn(power) ? alpha : R(0), colour);
}

// True if alpha is within both limits, and so equals exp2, at all pixels from (x0, y0) to (x1, y1);
// the minimum is at a corner. False also if rounding may affect the result.
template <class R>
HD bool covers(const Footprint<R>& f, R x0, R y0, R x1, R y1)
{
    const auto enough = [&](R x, R y) { return power_at(f, x, y) >= R(log2_min_alpha + 1e-2); };
    return f.peak <= R(log2_max_alpha) && enough(x0, y0) && enough(x1, y0) && enough(x0, y1) &&
           enough(x1, y1);
}

// The same as blend_deep() where covers() is true.
template <class R>
HD void blend_covered(Pixel<R>& p, const Footprint<R>& f, Vec3<R> colour, R x, R y)
{
    add(p, fast_exp2(power_at(f, x, y)), colour);
}

// The same as blend() with a mesh at depth `mesh` [m], which hides what is behind it.
template <class R>
HD void blend(Pixel<R>& p, const Footprint<R>& f, Vec3<R> colour, R x, R y, R mesh)
{
    const R power = power_at(f, x, y), depth = depth_at(f, x, y);
    if (!drawn(power)) return;
    if (depth <= mesh)
        add(p, alpha_of(power), colour, depth);
    else if (f.depth > R(mesh_slack) * mesh && !done(p))
        p.held = p.transmittance, p.transmittance = 0;
}

// Call after all splats: composites the pixel over the mesh (alpha 1) or the background (alpha 0).
// If the splats transmit at least half of the mesh's light, the pixel's depth is that of the mesh.
template <class R>
HD void finish(Pixel<R>& p, Vec3<R> behind, R alpha_behind, R mesh)
{
    p.transmittance = p.transmittance + p.held;
    p.colour = p.colour + p.transmittance * behind;
    if (takes_depth(p)) p.depth = min(mesh, R(no_depth));
    p.transmittance = p.transmittance * (1 - alpha_behind);
}

}  // namespace knead
