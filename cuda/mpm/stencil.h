// The 27 nodes around a particle and their quadratic B-spline weights.  (1), [Jiang 2016, eq. 123]
#pragma once
#include <type_traits>

#include "cuda/math/node4.h"
#include "cuda/mpm/lattice.h"

namespace knead {

template <class R>
struct Stencil {
    Int3 base;     // lowest of the 27 nodes
    Vec3<R> w[3];  // weight of node base + k along each axis
    Vec3<R> d;     // from the particle to base [m]

    // Of the node at `step` from the base, each axis 0, 1 or 2.
    HD R weight(Int3 step) const { return w[step.x].x * w[step.y].y * w[step.z].z; }
};

template <class R>
HD Int3 base_node(Vec3<R> x, std::type_identity_t<const Spacing<R>&> spacing)
{
    const R s = spacing.per_dx;
    return {int(s * x.x - R(0.5)), int(s * x.y - R(0.5)), int(s * x.z - R(0.5))};
}

template <class R>
HD Stencil<R> stencil(Vec3<R> x, std::type_identity_t<const Spacing<R>&> spacing)
{
    const Int3 base = base_node(x, spacing);
    const Vec3<R> g = spacing.per_dx * x;
    const Vec3<R> f = g - Vec3<R>{R(base.x), R(base.y), R(base.z)};  // in [0.5, 1.5)
    const auto sq = [](R s) { return s * s; };
    const auto each = [&](auto weight) { return Vec3<R>{weight(f.x), weight(f.y), weight(f.z)}; };
    return {base,
            {each([&](R t) { return R(0.5) * sq(R(1.5) - t); }),
             each([&](R t) { return R(0.75) - sq(t - R(1)); }),
             each([&](R t) { return R(0.5) * sq(t - R(0.5)); })},
            (-spacing.dx) * f};
}

// Its weights along x, each repeated over a node's four numbers: a row of three nodes, by
// row(Four...).
template <class R>
HD auto weights_along_x(const Stencil<R>& s)
{
    const auto all = [](R w) { return four(Vec3<R>{w, w, w}, w); };
    return row(all(s.w[0].x), all(s.w[1].x), all(s.w[2].x));
}

// Calls visit(step, weight, node position minus particle position) for each of the 27 nodes; step
// is the node less the stencil's base.
template <class R, class Visit>
HD void for_each_node(const Stencil<R>& s, R dx, Visit&& visit)
{
    UNROLL
    for (int n = 0; n < 27; ++n) {
        const Int3 step = {n % 3, n / 3 % 3, n / 9};
        visit(step, s.weight(step), s.d + Vec3<R>{dx * R(step.x), dx * R(step.y), dx * R(step.z)});
    }
}

}  // namespace knead
