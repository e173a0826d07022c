// The lattice of nodes, stored in blocks of 4 x 4 x 4.
#pragma once
#include "cuda/math/divisor.h"
#include "cuda/math/vec.h"

namespace knead {

// The spacing of the nodes, with its reciprocals. Functions that take it accept a plain distance.
template <class R>
struct Spacing {
    R dx, per_dx;  // [m], [1/m]
    R per_D;       // 4 / dx^2: the inverse of a quadratic stencil's second moment [1/m^2]
    HD Spacing(R spacing) : dx(spacing), per_dx(1 / spacing), per_D(4 / (spacing * spacing)) {}
};

// Lattice of nodes; node (i, j, k) lies at dx * (i, j, k). Stored are all nodes, or a box of them,
// in blocks of 4 x 4 x 4, so that a block's nodes are contiguous in memory. Blocks along z follow
// each other: the next node along z is always 16 further on, in the same block or not. Indices and
// counts of blocks refer to the stored box, coordinates of nodes and blocks to the whole lattice.
constexpr int block_edge = 4, block_nodes = 64;
template <class R>
struct Lattice {
    Int3 size;  // nodes along each axis, multiples of 4
    R dx;       // spacing [m]
    Spacing<R> spacing = dx;
    Int3 low{}, stored = size;  // the stored box: first node and size; multiples of 4
    // Strides in nodes: to the next node along z, to the next block along y and along x; and the
    // index that node (0, 0, 0) would have.
    static constexpr int along_z = block_edge * block_edge;
    int row = int(unsigned(stored.z) * along_z),
        slab = int(unsigned(stored.y / block_edge) * unsigned(row));
    int before = low.x / block_edge * slab + low.y / block_edge * row + low.z * along_z;
    Int3 first_block{low.x / block_edge, low.y / block_edge, low.z / block_edge};  // stored
    Divisor per_row{stored.z / block_edge};  // blocks, along z and in a plane of y and z
    Divisor per_slab{int(unsigned(stored.y / block_edge) * unsigned(stored.z / block_edge))};
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
        const Int3 s = blocks();
        const int x = per_slab.quotient(b), in_slab = b - x * (s.y * s.z);
        const int y = per_row.quotient(in_slab);
        return first_block + Int3{x, y, in_slab - y * s.z};
    }
    HD Int3 node_at(int i) const  // node coordinates of index i
    {
        const Int3 b = block_at(i >> 6);
        return {4 * b.x + (i & 3), 4 * b.y + (i >> 2 & 3), 4 * b.z + (i >> 4 & 3)};
    }
    HD Int3 cell_of(Vec3<R> x) const  // the cell that x is in, by its lowest node
    {
        const R s = spacing.per_dx;
        return {int(s * x.x), int(s * x.y), int(s * x.z)};
    }
    HD Vec3<R> position(Int3 n) const { return {dx * R(n.x), dx * R(n.y), dx * R(n.z)}; }
};

}  // namespace knead
