// Particle to grid: one particle adds its mass and momentum to 27 nodes.  (2), [Hu 2018, eq. 29]
#pragma once
#include "cuda/math/node4.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/momentum.h"
#include "cuda/mpm/particle.h"

namespace knead {

// The column of nodes along z at steps i and j, before the weights along z.
template <class R>
HD Four<R> column_of(const Momentum<R>& a, const Stencil<R>& s, int i, int j)
{
    Four<R> here = a.base;
    if (j) here = slid(here, R(j), a.along_y);
    if (i) here = slid(here, R(i), a.along_x);
    return (s.w[i].x * s.w[j].y) * here;
}

// Contribution to a node of a column: its weight `w` along z times the column's momentum there;
// `along_z` is the increment of velocity from the first node [m/s].
template <class R>
HD Four<R> along(Four<R> column, R w, Vec3<R> along_z)
{
    return w * slid(column, last(column), along_z);
}

// add(step, share) accesses the memory: a plain sum, a tile of shared memory, an atomic. `step` is
// the node less the stencil's base; momentum [kg m/s], mass [kg].
template <class R, class Add>
HD void scatter(const Particle<R>& q, const Material<R>& m, const Stencil<R>& s,
                std::type_identity_t<const Spacing<R>&> spacing, R dt, Add&& add)
{
    const Momentum<R> a = momentum(q, kirchhoff_stress(q, m), m, R(1) / m.mass, s, spacing, dt);
    UNROLL
    for (int n = 0; n < 9; ++n) {
        const Int3 step = {n % 3, n / 3, 0};
        const Four<R> column = column_of(a, s, step.x, step.y);
        UNROLL
        for (int k = 0; k < 3; ++k)
            add(step + Int3{0, 0, k}, node(along(column, s.w[k].z, R(k) * a.along_z)));
    }
}

// The same sums row by row, for registers that hold three nodes side by side; row(Four...) makes
// one. add(j, k, share) adds to the three nodes at steps j and k along y and z from the base.
// `base` holds momentum and mass, the others their increments from node to node.
// tests/solver/lanes_test.cpp compares the two forms.
template <class R, class Add>
HD void scatter_rows(Four<R> base, Four<R> by_x, Four<R> by_y, Four<R> by_z, const Stencil<R>& s,
                     Add&& add)
{
    const auto w = weights_along_x(s), first = w * row(base, base + by_x, base + R(2) * by_x),
               along_y = w * row(by_y, by_y, by_y), along_z = w * row(by_z, by_z, by_z);
    UNROLL
    for (int k = 0; k < 3; ++k) {
        const auto plane = k ? first + R(k) * along_z : first;
        UNROLL
        for (int j = 0; j < 3; ++j)
            add(j, k, (s.w[k].z * s.w[j].y) * (j ? plane + R(j) * along_y : plane));
    }
}

}  // namespace knead
