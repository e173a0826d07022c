// Particles on the device: six rows of 16 bytes, each contiguous over the particles, so that a
// warp's load of a row is coalesced. State used from substep to substep comes first, state only
// kept from frame to frame last.
//
// With few particles there are twelve rows, and one side is the first six, the other the last six;
// a sort moves all rows at once. With many there are seven, and one side is the first six, the
// other the last six; a sort moves them row by row, each into the free row.
#pragma once
#include <vector_types.h>

#include <bit>
#include <cstdint>

#include "cuda/mpm/particle.h"

namespace knead::gpu {

constexpr int particle_rows = 6;
// `Row` is float4, or const float4 for read-only access; likewise `Id`.
template <class Row, class Id>
struct ParticlesOf {
    Row* rows;  // particle_rows * count: (x, k), (e.xx e.yy e.zz, object), (e.xy e.xz e.yz,
                // sides), (v, C.a.x), (C.a.y C.a.z C.b.x C.b.y),
                // (C.b.z, C.c)
    Id* ids;    // count: index of the particle in the scene
    int count;

    HD Row& row(int r, int i) const { return rows[std::size_t(r) * std::size_t(count) + i]; }

    HD Vec3<float> position(int i) const
    {
        const float4 a = row(0, i);
        return {a.x, a.y, a.z};
    }
    // Position, strain, history: the state used from substep to substep. The rest is zero.
    HD Particle<float> load_state(int i) const
    {
        Particle<float> q{};
        load_place(i, q), load_strain(i, q);
        return q;
    }
    HD void load_place(int i, Particle<float>& q) const
    {
        const float4 a = row(0, i);
        q.x = {a.x, a.y, a.z}, q.k = a.w;
    }
    HD void load_strain(int i, Particle<float>& q) const
    {
        const float4 b = row(1, i), c = row(2, i);
        q.e = {b.x, b.y, b.z, c.x, c.y, c.z};
        q.object = std::bit_cast<int>(b.w), q.sides = std::bit_cast<std::uint32_t>(c.w);
    }
    HD Particle<float> load(int i) const
    {
        const float4 d = row(3, i), e = row(4, i), f = row(5, i);
        Particle<float> q = load_state(i);
        q.v = {d.x, d.y, d.z};
        q.C = {{d.w, e.x, e.y}, {e.z, e.w, f.x}, {f.y, f.z, f.w}};
        return q;
    }
    HD void set_sides(int i, std::uint32_t sides) const
    {
        row(2, i).w = std::bit_cast<float>(sides);
    }
    HD void store_state(int i, const Particle<float>& q) const
    {
        row(0, i) = {q.x.x, q.x.y, q.x.z, q.k};
        row(1, i) = {q.e.xx, q.e.yy, q.e.zz, std::bit_cast<float>(q.object)};
        row(2, i) = {q.e.xy, q.e.xz, q.e.yz, std::bit_cast<float>(q.sides)};
    }
    HD void store_motion(int i, const Particle<float>& q) const
    {
        row(3, i) = {q.v.x, q.v.y, q.v.z, q.C.a.x};
        row(4, i) = {q.C.a.y, q.C.a.z, q.C.b.x, q.C.b.y};
        row(5, i) = {q.C.b.z, q.C.c.x, q.C.c.y, q.C.c.z};
    }
    HD void store(int i, const Particle<float>& q) const { store_state(i, q), store_motion(i, q); }
};
using ParticleView = ParticlesOf<float4, int>;
using ConstParticleView = ParticlesOf<const float4, const int>;
HD ConstParticleView read_only(const ParticleView& p) { return {p.rows, p.ids, p.count}; }

// Memory for `count` particles, in elements of 16 bytes.
constexpr std::size_t row_places(std::size_t count)
{
    return (count > few_particles ? particle_rows + 1 : 2 * particle_rows) * count;
}

// A row that is free while `side` is current: scratch space of the sort, and output of depths.
HD float4* free_row(const ParticleView (&sides)[2], int side)
{
    return side ? sides[0].rows : &sides[0].row(particle_rows, 0);
}
// Whether the two sides do not overlap.
HD bool apart(const ParticleView (&sides)[2])
{
    return sides[1].rows == &sides[0].row(particle_rows, 0);
}

}  // namespace knead::gpu
