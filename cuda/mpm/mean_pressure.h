// Cell-averaged pressure of nearly incompressible solids and of liquids, against locking: three
// velocities per node cannot preserve the volumes of eight particles per cell individually.
// (7a), [Nagtegaal 1974]
#pragma once
#include "cuda/mpm/material.h"

namespace knead {

// Whether a material uses it: solids of a Poisson's ratio above 0.45, and liquids.
template <class R>
HD bool shares_pressure(const Material<R>& m)
{
    return m.plasticity == Plasticity::fluid ? m.bulk > 0 : m.lambda > R(9.01) * m.mu;
}

// A particle's own pressure [Pa]: the volumetric part of a solid's Kirchhoff stress; for a liquid B
// ln J, its pressure (7) to first order. What is compared is volume, and a linear law is invertible
// for liquids of any two B.
template <class R>
HD R own_pressure(const Particle<R>& q, const Material<R>& m)
{
    const R log_J = log_volume(determinant_excess(q.e));
    if (m.plasticity == Plasticity::fluid) return m.bulk * log_J;
    return volume_stress(m, snow_hardening(m, q.k), log_J);
}

// ln J at which clay has this pressure [Pa].
template <class R>
HD R log_volume_at(const Material<R>& m, R hardening, R pressure)
{
    if (m.plasticity == Plasticity::fluid) return pressure / m.bulk;
    const R p = pressure / (hardening * m.lambda);
    if (m.elasticity != Elasticity::fixed_corotated) return p;
    const R root = std::sqrt(max(R(0), 1 + 4 * p));  // (J - 1) J = p
    return std::log1p(2 * p / (1 + root));
}

// Sums over the particles of a cell: rest volume [m^3], and pressure times rest volume [Pa m^3]. A
// cell holds the particles whose stencils have the same base.
template <class R>
struct PressureSum {
    R pressure = 0, volume = 0;
    HD void add(R own, R volume_at_rest)
    {
        pressure += volume_at_rest * own, volume += volume_at_rest;
    }
    HD R mean() const { return pressure / volume; }
};

// Relaxation factor towards the cell's pressure per substep. With 1, differences within a cell
// would be damped by their stiffness times the substep, and only 0.7 of the longest substep would
// be stable: the square of that share is 1 - part / 2.
template <class R>
constexpr R part_borne = R(0.25);

// Relaxes the particle's volume towards the volume at this pressure; its shape is kept.
template <class R>
HD void apply_mean_pressure(Particle<R>& q, const Material<R>& m, R pressure)
{
    const R own = log_volume(determinant_excess(q.e));
    const R way = log_volume_at(m, snow_hardening(m, q.k), pressure) - own;
    const R more = std::expm1(R(2) / R(3) * part_borne<R> * way);  // of b
    q.e = raised((1 + more) * q.e, more);
}

}  // namespace knead
