// Displacement of a surface since the previous surface, from the change of density around it. Used
// to extrapolate the clay to the time at which a picture is displayed.
#pragma once
#include "cuda/math/vec.h"

namespace knead {

// Density and its gradient between nodes, by trilinear interpolation.
template <class R>
struct DensityAt {
    R value;
    Vec3<R> slope;  // [1/node]
};
// at(n) returns the density of a node; p is in units of nodes.
template <class R, class At>
HD DensityAt<R> density_at(Vec3<R> p, At&& at)
{
    const Int3 n = {int(std::floor(p.x)), int(std::floor(p.y)), int(std::floor(p.z))};
    const Vec3<R> f = p - Vec3<R>{R(n.x), R(n.y), R(n.z)};
    DensityAt<R> sum{0, {}};
    UNROLL
    for (int corner = 0; corner < 8; ++corner) {
        const Int3 step = {corner & 1, corner >> 1 & 1, corner >> 2};
        const R wx = step.x ? f.x : 1 - f.x, wy = step.y ? f.y : 1 - f.y,
                wz = step.z ? f.z : 1 - f.z;
        const R value = at(n + step);
        sum.value += wx * wy * wz * value;
        sum.slope =
            sum.slope + value * Vec3<R>{step.x ? wy * wz : -wy * wz, step.y ? wx * wz : -wx * wz,
                                        step.z ? wx * wy : -wx * wy};
    }
    return sum;
}

// Outward displacement at x [m]: a level set moves by the change of density over its slope. Clamped
// to one node, the range of the slope; 0 where the slope is negligible.
template <class R, class Now, class Past>
HD R advance(Vec3<R> x, R dx, Now&& now, Past&& past)
{
    const Vec3<R> p = (1 / dx) * x;
    const DensityAt<R> here = density_at(p, now), before = density_at(p, past);
    const R slope = R(0.5) * (length(here.slope) + length(before.slope));
    if (!(slope > R(1) / 32)) return 0;
    return dx * clamp((here.value - before.value) / slope, R(-1), R(1));
}

}  // namespace knead
