// Particle to grid: one particle hands its mass and momentum to 27 nodes.  (2), [Hu 2018, eq. 29]
#pragma once
#include "four.h"
#include "material.h"
#include "stencil.h"

namespace knead {

// add(step, share) is where the memory is: a plain sum, a tile of shared memory, an atomic.
// `step` is the node less the stencil's base; momentum [kg m/s], mass [kg].
template <class R, class Add>
HD void scatter(const Particle<R>& q, const Material<R>& m, const Stencil<R>& s, R dx, R dt,
                Add&& add)
{
    const Mat3<R> Q =
        m.mass * q.C - (4 * dt * m.volume / (dx * dx)) * full(kirchhoff_stress(q, m));
    const Four<R> base = four(m.mass * q.v + Q * s.d, m.mass);  // per weight, at the base node
    const Mat3<R> by_step = dx * Q;
    UNROLL
    for (int n = 0; n < 27; ++n) {
        const Int3 step = {n % 3, n / 3 % 3, n / 9};
        const R w = s.w[step.z].z * s.w[step.y].y * s.w[step.x].x;
        Four<R> here = base;
        if (step.z) here = slid(here, R(step.z), by_step.c);
        if (step.y) here = slid(here, R(step.y), by_step.b);
        if (step.x) here = slid(here, R(step.x), by_step.a);
        add(step, node(w * here));
    }
}

}  // namespace knead
