// What one particle hands to its nodes, before the weights.  (2), [Hu 2018, eq. 29]
#pragma once
#include "cuda/math/node4.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/stencil.h"

namespace knead {

// The momentum's gradient [kg/s] of a particle of affine velocity C, Kirchhoff stress tau [Pa],
// that mass [kg] and volume at rest [m^3].
template <class R>
HD Mat3<R> momentum_gradient(const Mat3<R>& C, const Sym3<R>& tau, R mass, R volume,
                             std::type_identity_t<const Spacing<R>&> spacing, R dt)
{
    return mass * C - (dt * volume * spacing.per_D) * full(tau);
}

// Momentum [kg m/s] and mass [kg] per weight: at the stencil's base node, and by how much the
// momentum grows from node to node along x, y and z.
template <class R>
struct Momentum {
    Four<R> base;
    Mat3<R> by_step;
};

// Of a particle whose Kirchhoff stress is tau [Pa].
template <class R>
HD Momentum<R> momentum(const Particle<R>& q, const Sym3<R>& tau, const Material<R>& m,
                        const Stencil<R>& s, std::type_identity_t<const Spacing<R>&> spacing, R dt)
{
    const Mat3<R> Q = momentum_gradient(q.C, tau, m.mass, m.volume, spacing, dt);
    return {four(m.mass * q.v + Q * s.d, m.mass), spacing.dx * Q};
}

}  // namespace knead
