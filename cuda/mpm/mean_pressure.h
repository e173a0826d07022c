// Clay that hardly changes its volume, and liquids, bear their cell's mean pressure: three
// velocities a node cannot keep the volumes of eight particles a cell, each by itself.
// (7a), [Nagtegaal 1974]
#pragma once
#include "cuda/mpm/material.h"

namespace knead {

// Whether clay of this material does: solids of a Poisson's ratio above 0.45, and liquids.
template <class R>
HD bool shares_pressure(const Material<R>& m)
{
    return m.plasticity == Plasticity::fluid ? m.bulk > 0 : m.lambda > R(9.01) * m.mu;
}

// A particle's own part of it [Pa]: what of a solid's Kirchhoff stress the volume decides; of a
// liquid B ln J, its pressure (7) to first order. Volumes are compared, not pressures, and
// a straight line has an inverse for liquids of any two B.
template <class R>
HD R own_pressure(const Particle<R>& q, const Material<R>& m)
{
    const R log_J = log_volume(determinant_excess(q.e));
    if (m.plasticity == Plasticity::fluid) return m.bulk * log_J;
    return volume_stress(m, snow_hardening(m, q.k), log_J);
}

// ln J of clay that has this part [Pa].
template <class R>
HD R log_volume_at(const Material<R>& m, R hardening, R pressure)
{
    if (m.plasticity == Plasticity::fluid) return pressure / m.bulk;
    const R p = pressure / (hardening * m.lambda);
    if (m.elasticity != Elasticity::fixed_corotated) return p;
    const R root = std::sqrt(max(R(0), 1 + 4 * p));  // (J - 1) J = p
    return std::log1p(2 * p / (1 + root));
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
    HD R mean() const { return pressure / volume; }
};

// The part of the way to its cell's pressure that a particle goes in a substep. If it went all of
// it, what is apart in a cell would be damped by its stiffness times the substep, and 0.7 of the
// longest substep would be stable: the square of that share is 1 - part / 2.
template <class R>
constexpr R part_borne = R(0.25);

// The particle's volume goes towards the one that has this pressure; its shape stays.
template <class R>
HD void apply_mean_pressure(Particle<R>& q, const Material<R>& m, R pressure)
{
    const R own = log_volume(determinant_excess(q.e));
    const R way = log_volume_at(m, snow_hardening(m, q.k), pressure) - own;
    const R more = std::expm1(R(2) / R(3) * part_borne<R> * way);  // of b
    q.e = raised((1 + more) * q.e, more);
}

}  // namespace knead
