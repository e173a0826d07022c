// The part of the lattice that the device stores: the bounding box of the clay and a margin. Before
// clay reaches an end of the box, a frame stops at the end of a substep, and resumes when the box
// has grown; so node access needs no bounds check.
#pragma once
#include <bit>

#include "cuda/math/box.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/stencil.h"
#include "cuda/mpm/walls.h"

namespace knead {

// Positions whose whole stencil is stored [m]. A particle that tools push out of this region is
// clamped to the nearest position in it until more nodes are stored; then the tools push it on.
inline Box3<float> stored_region(const Lattice<float>& l)
{
    // 0.01 cells for rounding.
    const auto min = [&l](int low) { return l.dx * (float(low) + 0.51f); };
    const auto max = [&l](int past) { return l.dx * (float(past) - 1.51f); };
    const Int3 end = l.low + l.stored;
    return {{min(l.low.x), min(l.low.y), min(l.low.z)}, {max(end.x), max(end.y), max(end.z)}};
}

// The part of that region inside the walls (project.h): most clay needs no other test.
inline Box3<float> free_region(const Lattice<float>& l, const Walls<float>& walls)
{
    const Box3<float> p = stored_region(l);
    return {greater(p.low, walls.min), lesser(p.high, walls.max)};
}

// Ends of the box that block b is at and that are not ends of the lattice, as bits: 1 << 2 * axis
// for the low end, twice that for the high one. A frame stops one or two substeps after clay has
// reached the block, and it moves at most one cell in each.
inline unsigned ends_at(const Lattice<float>& l, Int3 b)
{
    const auto axis = [](int at, int low, int stored, int size) {
        const bool first = at == low && low > 0, last = at + block_edge == low + stored;
        return unsigned(first) + 2 * unsigned(last && low + stored < size);
    };
    return axis(block_edge * b.x, l.low.x, l.stored.x, l.size.x) |
           axis(block_edge * b.y, l.low.y, l.stored.y, l.size.y) << 2 |
           axis(block_edge * b.z, l.low.z, l.stored.z, l.size.z) << 4;
}

// The lattice with nodes low <= n < end stored, extended to whole blocks and clipped to the
// lattice.
inline Lattice<float> boxed(const Lattice<float>& whole, Int3 low, Int3 end)
{
    const auto down = [](int n) { return max(n, 0) & ~(block_edge - 1); };
    const auto up = [](int n, int size) {
        return min((n + block_edge - 1) & ~(block_edge - 1), size);
    };
    const Int3 from{down(low.x), down(low.y), down(low.z)};
    const Int3 to{up(end.x, whole.size.x), up(end.y, whole.size.y), up(end.z, whole.size.z)};
    return {whole.size, whole.dx, whole.spacing, from, to - from};
}

// Extends rows along z to a power of two nodes. With other lengths a warp's loads are spread less
// evenly over the slices of L2, and `g2p` takes 3 % longer [docs/engineering/memory.md]. Unchanged
// if such a row does not fit in the lattice or is longer by more than three fifths.
inline Lattice<float> in_even_rows(const Lattice<float>& l)
{
    const int row = l.stored.z, even = int(std::bit_ceil(unsigned(row)));
    if (even > l.size.z || 5 * even > 8 * row) return l;
    const int mid_frame = min(max(l.low.z - (even - row) / 2, 0), l.size.z - even);
    const int from = mid_frame & ~(block_edge - 1);
    const Int3 end = l.low + l.stored;
    return boxed(l, {l.low.x, l.low.y, from}, {end.x, end.y, from + even});
}

// Box around clay whose stencils cover the nodes low <= n < end. Margin on every side: an eighth of
// its extent, at least a block; for spare >= 0, a block and `spare` nodes.
inline Lattice<float> box_around(const Lattice<float>& whole, Int3 low, Int3 end, int spare)
{
    const auto room = [spare](int extent) {
        return spare < 0 ? max(extent / 8, block_edge) : block_edge + spare;
    };
    const Int3 extent = end - low;
    const Int3 more{room(extent.x), room(extent.y), room(extent.z)};
    return in_even_rows(boxed(whole, low - more, end + more));
}

// Enlarged by a quarter, at least two blocks, at each of `ends`.
inline Lattice<float> grown(const Lattice<float>& l, unsigned ends)
{
    Int3 from = l.low, to = l.low + l.stored;
    const auto axis = [ends](int k, int& low, int& end) {
        const int more = max((end - low) / 4, 2 * block_edge);
        if (ends >> 2 * k & 1) low -= more;
        if (ends >> 2 * k & 2) end += more;
    };
    axis(0, from.x, to.x), axis(1, from.y, to.y), axis(2, from.z, to.z);
    return in_even_rows(boxed(l, from, to));
}

}  // namespace knead
