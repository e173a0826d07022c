// Transfers of a group of particles: to the grid and back.
#pragma once
#include "cuda/math/node4.h"
#include "cuda/mpm/g2p.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/momentum.h"
#include "cuda/mpm/p2g.h"
#include "cuda/mpm/particle.h"
#include "host/solver/cpu/material.h"
#include "host/solver/cpu/rows.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

// Contribution of a group to its nodes: momentum and mass at the base node, and their increments
// per node along each axis.
template <class R>
struct Impulses {
    Stencils<R> stencils;
    Four<R> base[Group<R>::count], by_x[Group<R>::count], by_y[Group<R>::count],
        by_z[Group<R>::count];
    explicit Impulses(const Stencils<R>& s) : stencils(s) {}
};

template <class R>
[[gnu::always_inline]] inline Impulses<R> impulses(const Group<R>& group, const Material<R>& m,
                                                   Vec3<R> rise, R dx, R dt)
{
    using L = Lanes<R>;
    Particle<L> p = load(group);
    p.v = p.v + Vec3<L>{L(rise.x), L(rise.y), L(rise.z)};
    Impulses<R> out(Stencils<R>(p.x, dx));
    const Mat3<L> Q =
        momentum_gradient(p.C, stress(p, group, m), L(m.mass), L(m.volume), L(dx), L(dt));
    const Mat3<L> by_step = L(dx) * Q;
    spread(L(m.mass) * p.v + Q * out.stencils.d(), L(m.mass), out.base);
    spread(by_step.a, L(0), out.by_x);
    spread(by_step.b, L(0), out.by_y);
    spread(by_step.c, L(0), out.by_z);
    return out;
}

// A group after its move, and the mass around each particle per cell, in particle masses.
template <class R>
struct Moved {
    Particle<Lanes<R>> p;
    Each<R> per_cell;
};

// Gathers and advects a group. nodes(lane, base) returns the first node of that particle's stencil
// in a tile.
template <class R, class Nodes>
[[gnu::always_inline]] inline Moved<R> gather_and_move(const Group<R>& group, R mass, R dx, R dt,
                                                       Nodes&& nodes)
{
    using L = Lanes<R>;
    Moved<R> moved;
    Particle<L>& p = moved.p;
    load_shape(group, p);
    const Stencils<R> stencils(p.x, dx);
    Four<R> v[L::count], by_x[L::count], by_y[L::count], by_z[L::count];
    Each<R> nearest;  // mass of the nearest node, in particle masses
    for (int l = 0; l < L::count; ++l) {
        const Stencil<R> s = stencils[l];
        const Node<R>* base = nodes(l, s.base);
        const Gathered<R> sum = gather_rows(s, [&](int j, int k) {
            return row_at(base + tile_index({0, j, k}));
        });
        nearest.of[l] = base[tile_index(nearest_node)].m / mass;
        moved.per_cell.of[l] = mass_around(sum.v) / mass;
        v[l] = sum.v, by_x[l] = sum.by_x, by_y[l] = sum.by_y, by_z[l] = sum.by_z;
    }
    p.v = collected(v);
    p.C = velocity_gradient(p.v, {collected(by_x), collected(by_y), collected(by_z)}, stencils.d(),
                            L(dx));
    damp_isolated_particle(p.C, nearest.lanes());
    p.e = advance_b(p.e, p.C, L(dt));
    p.x = p.x + L(dt) * p.v;
    store(p, group);
    return moved;
}

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
