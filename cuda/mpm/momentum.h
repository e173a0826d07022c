// The momentum that a particle scatters to its nodes, before the weights.  (2), [Hu 2018, eq. 29]
#pragma once
#include "cuda/math/node4.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/stencil.h"

namespace knead {

// Gradient of the momentum [kg/s] of a particle with affine velocity C, Kirchhoff stress tau [Pa],
// mass [kg] and rest volume [m^3].
template <class R>
HD Mat3<R> momentum_gradient(const Mat3<R>& C, const Sym3<R>& tau, R mass, R volume,
                             std::type_identity_t<const Spacing<R>&> spacing, R dt)
{
    return mass * C - (dt * volume * spacing.per_D) * full(tau);
}

// Momentum [kg m/s] and mass [kg] per weight: at the stencil's base node, and the increments from
// node to node; along z as velocity [m/s], the same for every column of nodes.
template <class R>
struct Momentum {
    Four<R> base;
    Vec3<R> along_x, along_y;  // [kg m/s]
    Vec3<R> along_z;           // [m/s]
};

// For a particle whose Kirchhoff stress is tau [Pa]; per_mass is 1 / m.mass.
//
// The base's share of the increment along z uses the same rounded velocity, times the first moment
// of the weights. Computed from Q and the stencil's d it would differ by the rounding error of 1 /
// m.mass, which is the same for all particles and substeps: the momentum of a flying, spinning ball
// drifted by 1e-8 in each.
template <class R>
HD Momentum<R> momentum(const Particle<R>& q, const Sym3<R>& tau, const Material<R>& m, R per_mass,
                        const Stencil<R>& s, std::type_identity_t<const Spacing<R>&> spacing, R dt)
{
    const Mat3<R> Q = momentum_gradient(q.C, tau, m.mass, m.volume, spacing, dt);
    const Vec3<R> along_z = per_mass * (spacing.dx * Q.c);
    const R above_base = R(1) + (s.w[2].z - s.w[0].z);  // in cells
    const Vec3<R> p = m.mass * (q.v - above_base * along_z) + s.d.x * Q.a + s.d.y * Q.b;
    return {four(p, m.mass), spacing.dx * Q.a, spacing.dx * Q.b, along_z};
}

}  // namespace knead
