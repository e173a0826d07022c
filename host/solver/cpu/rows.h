// Vectorised access to three nodes at a time: a row of the stencil is twelve consecutive numbers in
// a tile, in one or a few vector registers. The row sums are in p2g.h and g2p.h.
#pragma once
#include "cuda/math/node4.h"
#include "cuda/mpm/lattice.h"
#include "host/solver/cpu/group.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

constexpr int tile_edge = block_edge + 2, tile_nodes = tile_edge * tile_edge * tile_edge;

inline int tile_index(Int3 n) { return (n.z * tile_edge + n.y) * tile_edge + n.x; }

// The nodes that a block's particles can reach, plus one as padding of the last row.
template <class R>
struct alignas(64) Tile {
    Node<R> node[tile_nodes + 1];
};

// Three neighbours along x. Wider registers include a fourth node, to which zero is added.
template <class R>
struct Row {
    using Part = typename Register<R>::V;
    static constexpr int width = Lanes<R>::count, parts = (12 + width - 1) / width;
    Part part[parts];
};

template <class R>
inline Row<R> operator+(Row<R> a, const Row<R>& b)
{
    UNROLL
    for (int i = 0; i < Row<R>::parts; ++i) a.part[i] += b.part[i];
    return a;
}
template <class R>
inline Row<R> operator*(Row<R> a, const Row<R>& b)
{
    UNROLL
    for (int i = 0; i < Row<R>::parts; ++i) a.part[i] *= b.part[i];
    return a;
}
template <class R>
inline Row<R> operator*(R s, Row<R> a)
{
    UNROLL
    for (int i = 0; i < Row<R>::parts; ++i) a.part[i] *= s;
    return a;
}

template <class R>
inline Row<R> row(Four<R> a, Four<R> b, Four<R> c)
{
    constexpr typename Four<R>::V none{};
    if constexpr (Row<R>::width == 4)
        return {{a.v, b.v, c.v}};
    else if constexpr (Row<R>::width == 8)
        return {{joined(a.v, b.v), joined(c.v, none)}};
    else
        return {{joined(joined(a.v, b.v), joined(c.v, none))}};
}
// Node k of a row.
template <int k, class R>
inline Four<R> node_of(const Row<R>& a)
{
    constexpr int at = 4 * k % Row<R>::width;
    const auto& v = a.part[4 * k / Row<R>::width];
    return {__builtin_shufflevector(v, v, at, at + 1, at + 2, at + 3)};
}
// Copied register by register: GCC splits larger copies into pieces, on which the next load stalls.
template <class R>
inline Row<R> row_at(const Node<R>* first)
{
    using Part = typename Row<R>::Part;
    Row<R> a;
    UNROLL
    for (int i = 0; i < Row<R>::parts; ++i)
        std::memcpy(&a.part[i], reinterpret_cast<const char*>(first) + i * sizeof(Part),
                    sizeof(Part));
    return a;
}
template <class R>
inline void add(const Row<R>& a, Node<R>* first)
{
    using Part = typename Row<R>::Part;
    const Row<R> sum = row_at(first) + a;
    UNROLL
    for (int i = 0; i < Row<R>::parts; ++i)
        std::memcpy(reinterpret_cast<char*>(first) + i * sizeof(Part), &sum.part[i], sizeof(Part));
}

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
