// Clay that hardly changes its volume bears its cell's mean pressure: three velocities a node
// cannot keep the volumes of eight particles a cell, each by itself.  (7a), [Nagtegaal 1974]
#pragma once
#include "cuda/mpm/material.h"

namespace knead {

// Whether clay of this material does: solids of a Poisson's ratio above 0.45.
template <class R>
HD bool shares_pressure(const Material<R>& m)
{
    return m.plasticity != Plasticity::fluid && m.lambda > R(9.01) * m.mu;
}

// A solid particle's own part of it: what of its Kirchhoff stress the volume decides [Pa].
template <class R>
HD R own_pressure(const Particle<R>& q, const Material<R>& m)
{
    return volume_stress(m, snow_hardening(m, q.k), log_volume(determinant_excess(q.e)));
}

// Of the particles of a cell that share it: their volumes at rest [m^3], and the pressure times
// these [Pa m^3]. Cells are those of particles whose stencils begin at one node.
template <class R>
struct PressureSum {
    R pressure = 0, volume = 0;
    HD void add(R own, R volume_at_rest)
    {
        pressure += volume_at_rest * own, volume += volume_at_rest;
    }
    // What the mean adds to a particle's own [Pa].
    HD R beyond(R own) const { return pressure / volume - own; }
};

}  // namespace knead
