// Density to triangles: crossed edges by node, triangles by cell. A vertex belongs to an edge of
// the lattice, an edge to the node at its low end.  [Lorensen 1987]
#pragma once
#include <cstdint>

#include "cuda/math/vec.h"
#include "cuda/surface/march_table.h"

namespace knead {

// A density equal to iso is outside, and so is NaN.
template <class R>
HD bool is_inside(R density, R iso)
{
    return density > iso;
}

// Which of a node's three edges the surface crosses, as bits 1 << axis; value(axis) returns the
// density one step along the axis.
template <class R, class Value>
HD unsigned crossed_edges(R here, R iso, Value&& value)
{
    const bool in = is_inside(here, iso);
    unsigned crossed = 0;
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
        if (is_inside<R>(value(axis), iso) != in) crossed |= 1u << axis;
    return crossed;
}

// Number of bits below an axis: the rank of its vertex among its node's. For axis 3: all.
HD int rank_of(unsigned crossed, int axis)
{
    const unsigned before = crossed & ((1u << axis) - 1);
    return int(before & 1) + int(before >> 1 & 1) + int(before >> 2);
}

// Fraction of the edge from `low` to `high` at which the density is iso. Measured from the outer
// end, whose density is finite, and kept off both ends: no two edges of a node share a vertex
// position, and no triangle is degenerate.
template <class R>
HD R crossing(R low, R high, R iso)
{
    const bool in = is_inside(low, iso);
    const R outer = in ? high : low, inner = in ? low : high;
    const R t = clamp((iso - outer) / (inner - outer), R(1) / 64, R(63) / 64);
    return in ? 1 - t : t;
}

template <class R>
HD Vec3<R> crossing_point(Int3 n, int axis, R share, R dx)
{
    const Vec3<R> along{R(axis == 0), R(axis == 1), R(axis == 2)};
    return dx * (Vec3<R>{R(n.x), R(n.y), R(n.z)} + share * along);
}

// The cell's case; value(corner) returns the density at a corner of march_table.h.
template <class R, class Value>
HD int cell_case(R iso, Value&& value)
{
    int inside = 0;
    UNROLL
    for (int corner = 0; corner < 8; ++corner)
        inside |= int(is_inside<R>(value(corner), iso)) << corner;
    return inside;
}

// vertex(low corner, axis) returns the index of the vertex on that edge; emit(k, triangle) receives
// the cell's k-th triangle.
template <class Vertex, class Emit>
HD void march(int inside, const MarchTable& table, Vertex&& vertex, Emit&& emit)
{
    const auto at = [&](int e) { return vertex(low_corner(e), e / 4); };
    for (int k = 0; k < table.count[inside]; ++k) {
        const std::uint8_t* const edge = table.edge[inside] + 3 * k;
        emit(k, Int3{at(edge[0]), at(edge[1]), at(edge[2])});
    }
}

}  // namespace knead
