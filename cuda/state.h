// What is simulated, plainly. Metres, kilograms, seconds, pascals.
#pragma once
#include <cstdint>

#include "vec.h"

namespace knead {

enum class Elasticity : int { neo_hookean, fixed_corotated, hencky };
enum class Flow : int { none, von_mises, drucker_prager, clamp, herschel_bulkley, fluid };

// One object's material, with what its particles share.
template <class R>
struct Material {
    Elasticity elasticity;
    Flow flow;
    R density;      // at rest [kg/m^3]
    R mu, lambda;   // Lame parameters [Pa]
    R bulk;         // of a fluid: slope of its pressure [Pa]
    R yield;        // von Mises, Herschel-Bulkley: uniaxial yield stress [Pa]
    R hardening;    // von Mises: slope of the yield stress over plastic strain [Pa]; < 0 softens
    R yield_floor;  // von Mises: softening stops here [Pa]
    R friction;     // Drucker-Prager: |dev tau| <= friction * pressure [1]
    R cohesion;     // Drucker-Prager: Hencky volume strain that the cone's tip bears [1]
    R compress, stretch;  // clamp: singular values stay in [1 - compress, 1 + stretch]
    R snow;               // clamp: hardening exponent [1]
    R viscosity;          // fluid: [Pa s]; Herschel-Bulkley: consistency [Pa s^exponent]
    R exponent;           // Herschel-Bulkley: flow index [1]; fluid: of the pressure law [1]
    R mass, volume;       // of one particle at rest [kg] [m^3]
    int category;         // surfaces are made per category
};

// One material point. `e` is the elastic left Cauchy-Green strain b - I: stored less the identity,
// so that small strains of a stiff material keep their digits in float.
template <class R>
struct Particle {
    Vec3<R> x, v;  // position [m], velocity [m/s]
    Mat3<R> C;     // affine velocity, the velocity's gradient around the particle [1/s]
    Sym3<R> e;     // b - I [1]
    R k;           // von Mises and Herschel-Bulkley: accumulated plastic strain; Drucker-Prager:
                   // volume correction; clamp: ln of the plastic volume ratio [1]
    int object;    // index of its Material
    std::uint32_t sides;  // which side of a cut, see blade.h; the top bit: held where it is, see
                          // rest.h
    // Whoever moves particles of scenes in which none is held need not know: it costs registers.
    HD bool still() const { return (sides & still_bit) != 0; }
    HD std::uint32_t label() const { return sides & ~still_bit; }
    HD void hold(bool held) { sides = label() | (held ? still_bit : 0); }
    static constexpr std::uint32_t still_bit = 1u << 31;
};

// One lattice point: first momentum and mass, after the grid update velocity and mass.
template <class R>
struct Node {
    Vec3<R> p;  // momentum [kg m/s], then velocity [m/s]
    R m;        // mass [kg]
};

// The distance of neighbouring nodes, with what it divides. Functions that ask for it take a plain
// distance, too.
template <class R>
struct Spacing {
    R dx, per_dx;  // [m], [1/m]
    R per_D;       // 4 / dx^2: the inverse of a quadratic stencil's second moment [1/m^2]
    HD Spacing(R spacing) : dx(spacing), per_dx(1 / spacing), per_D(4 / (spacing * spacing)) {}
};

// A lattice of nodes; node (i, j, k) sits at dx * (i, j, k), for every stage. Stored is all of it,
// or a box of it; in blocks of 4 x 4 x 4 nodes, so that a block's nodes are neighbours in memory,
// and blocks along z follow each other: the next node along z is always 16 further on, whether in
// the same block or not. Indices and numbers of blocks are of what is stored, coordinates of nodes
// and of blocks are those of the whole lattice.
constexpr int block_edge = 4, block_nodes = 64;
template <class R>
struct Lattice {
    Int3 size;  // nodes along each axis, multiples of 4
    R dx;       // spacing [m]
    Spacing<R> spacing = dx;
    Int3 low{}, stored = size;  // nodes from `low` on, so many along each axis; multiples of 4
    // How far on in memory, in nodes: the next node along z, the next block along y and along x;
    // where node (0, 0, 0) would be before the first that is stored.
    static constexpr int along_z = block_edge * block_edge;
    int row = int(unsigned(stored.z) * along_z),
        slab = int(unsigned(stored.y / block_edge) * unsigned(row));
    int before = low.x / block_edge * slab + low.y / block_edge * row + low.z * along_z;
    Int3 first_block{low.x / block_edge, low.y / block_edge, low.z / block_edge};  // stored
    HD Int3 end_block() const { return first_block + blocks(); }  // along each axis after the last
    HD Int3 blocks() const
    {
        return {stored.x / block_edge, stored.y / block_edge, stored.z / block_edge};
    }
    HD int block_count() const { return stored.x / 4 * (stored.y / 4) * (stored.z / 4); }
    HD int node_count() const { return stored.x * stored.y * stored.z; }
    HD bool stores(Int3 n) const
    {
        const Int3 at = n - low;
        return unsigned(at.x) < unsigned(stored.x) && unsigned(at.y) < unsigned(stored.y) &&
               unsigned(at.z) < unsigned(stored.z);
    }
    HD int along_x(int x) const { return (x >> 2) * slab + (x & 3); }
    HD int along_y(int y) const { return (y >> 2) * row + (y & 3) * 4; }
    HD int index(Int3 n) const { return along_x(n.x) + along_y(n.y) + n.z * along_z - before; }
    HD int block_of(Int3 n) const { return index({n.x & ~3, n.y & ~3, n.z & ~3}) / block_nodes; }
    HD int stepped(int i, Int3 step) const  // index of the node 0 to 4 steps from that of index i
    {
        const int x = (i & 3) + step.x, y = (i >> 2 & 3) + step.y;
        return i + step.x + 4 * step.y + along_z * step.z + (x >> 2) * (slab - 4) +
               (y >> 2) * (row - 16);
    }
    HD Int3 block_at(int b) const  // block coordinates of block b
    {
        const Int3 s = blocks(), first = first_block;
        return {b / (s.y * s.z) + first.x, b / s.z % s.y + first.y, b % s.z + first.z};
    }
    HD Int3 node_at(int i) const  // node coordinates of index i
    {
        const Int3 b = block_at(i / block_nodes);
        const int l = i % block_nodes;
        return {4 * b.x + l % 4, 4 * b.y + l / 4 % 4, 4 * b.z + l / 16};
    }
    HD Int3 cell_of(Vec3<R> x) const  // the cell that x is in, by its lowest node
    {
        const R s = spacing.per_dx;
        return {int(s * x.x), int(s * x.y), int(s * x.z)};
    }
    HD Vec3<R> position(Int3 n) const { return {dx * R(n.x), dx * R(n.y), dx * R(n.z)}; }
};

// Looks at memory on either side and owns none of it.
template <class T>
struct Span {
    T* data;
    int count;
    HD T& operator[](int i) const { return data[i]; }
    HD T* begin() const { return data; }
    HD T* end() const { return data + count; }
};

// How a surface acts on what touches it.
enum class Touch : int { sticky, slip, separate };

// The box the clay lives in: its six inner faces stand `margin` nodes inside the lattice.
template <class R>
struct Walls {
    int margin;  // nodes; at least 2, so that no stencil leaves the lattice
    Touch touch;
    R friction;  // Coulomb [1]
};

template <class To, class From>
HD Material<To> cast(const Material<From>& m)
{
    return {m.elasticity,   m.flow,         To(m.density),   To(m.mu),          To(m.lambda),
            To(m.bulk),     To(m.yield),    To(m.hardening), To(m.yield_floor), To(m.friction),
            To(m.cohesion), To(m.compress), To(m.stretch),   To(m.snow),        To(m.viscosity),
            To(m.exponent), To(m.mass),     To(m.volume),    m.category};
}

template <class To, class From>
HD Particle<To> cast(const Particle<From>& q)
{
    return {cast<To>(q.x),
            cast<To>(q.v),
            {cast<To>(q.C.a), cast<To>(q.C.b), cast<To>(q.C.c)},
            {To(q.e.xx), To(q.e.yy), To(q.e.zz), To(q.e.xy), To(q.e.xz), To(q.e.yz)},
            To(q.k),
            q.object,
            q.sides};
}

}  // namespace knead
