// Particles to density, in units of rest density (1 = full), on a separate lattice: deposits each
// particle's rest volume on 27 nodes, then smooths until single particles vanish.
#pragma once
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/stencil.h"

namespace knead {

// `share` is the particle's rest volume over the volume of a cell [1]. add(step, part) accesses the
// memory; `step` is the node less the stencil's base.
template <class R, class Add>
HD void deposit(const Stencil<R>& s, R share, Add&& add)
{
    UNROLL
    for (int n = 0; n < 27; ++n) {
        const Int3 step = {n % 3, n / 3 % 3, n / 9};
        add(step, share * (s.w[step.z].z * s.w[step.y].y * s.w[step.x].x));
    }
}

// Whether all 27 nodes of a particle at x are on the lattice. False for NaN.
template <class R>
HD bool inside(Vec3<R> x, const Lattice<R>& lattice)
{
    const R s = 1 / lattice.dx;
    const auto within = [s](R t, int size) { return s * t >= R(0.5) && s * t < R(size) - R(1.5); };
    return within(x.x, lattice.size.x) && within(x.y, lattice.size.y) &&
           within(x.z, lattice.size.z);
}

// One node after one binomial pass along one axis; value(step) returns the neighbour at step -1, 0
// or 1. A pass along every axis adds half a dx^2 to the variance of the kernel.
template <class R, class Value>
HD R smoothed(Value&& value)
{
    return R(0.25) * (value(-1) + value(1)) + R(0.5) * value(0);
}

// The kernel's variance, along one axis, in squares of the particles' spacing. Randomly placed
// particles then give a density of 1 +- 0.13: iso = 1/2 is four deviations away, and the surface
// has no pits. The cost is the curvature bias of any blurred ball of radius r: its surface at iso =
// 1/2 is variance / r too low.  [Merriman 1992]
template <class R>
constexpr R kernel_variance = R(1.25);
constexpr int max_smoothing_passes = 24;

// Binomial passes that widen the quadratic B-spline (variance dx^2 / 4) to kernel_variance, for
// particles of a rest volume [m^3].
template <class R>
HD int smoothing_passes(R volume, R dx)
{
    const R spacing = std::cbrt(volume) / dx;
    const R passes = 2 * (kernel_variance<R> * spacing * spacing - R(0.25));
    return int(clamp(passes + R(0.5), R(0), R(max_smoothing_passes)));
}

}  // namespace knead
