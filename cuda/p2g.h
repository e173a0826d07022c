// Particle to grid: one particle hands its mass and momentum to 27 nodes.  (2), [Hu 2018, eq. 29]
#pragma once
#include "momentum.h"

namespace knead {

// The row of nodes along x at steps j and k, before the weights along x.
template <class R>
HD Four<R> row_of(const Momentum<R>& a, const Stencil<R>& s, int j, int k)
{
    Four<R> here = a.base;
    if (k) here = slid(here, R(k), a.by_step.c);
    if (j) here = slid(here, R(j), a.by_step.b);
    return (s.w[k].z * s.w[j].y) * here;
}

// Node i of a row: its weight `w` along x times the row's momentum there; `per_mass_x` is by_step
// along x over the particle's mass [m/s].
template <class R>
HD Four<R> along(Four<R> row, R i, R w, Vec3<R> per_mass_x)
{
    return w * slid(row, i * last(row), per_mass_x);
}

// add(step, share) is where the memory is: a plain sum, a tile of shared memory, an atomic.
// `step` is the node less the stencil's base; momentum [kg m/s], mass [kg].
template <class R, class Add>
HD void scatter(const Particle<R>& q, const Material<R>& m, const Stencil<R>& s, R dx, R dt,
                Add&& add)
{
    const Momentum<R> a = momentum(q, kirchhoff_stress(q, m), m, s, dx, dt);
    const Vec3<R> per_mass_x = (1 / m.mass) * a.by_step.a;
    UNROLL
    for (int n = 0; n < 9; ++n) {
        const Int3 step = {0, n % 3, n / 3};
        const Four<R> row = row_of(a, s, step.y, step.z);
        UNROLL
        for (int i = 0; i < 3; ++i)
            add(step + Int3{i, 0, 0}, node(along(row, R(i), s.w[i].x, per_mass_x)));
    }
}

}  // namespace knead
