// The transfers three nodes at a time: a row of the stencil is twelve numbers side by side in a
// tile, which one vector register holds, or a few. The sums are those of p2g.h and g2p.h in
// another order; tests/solver/lanes_test.cpp compares the two.
#pragma once
#include "cuda/math/node4.h"
#include "cuda/mpm/lattice.h"
#include "host/solver/cpu/group.h"

namespace knead {

constexpr int tile_edge = block_edge + 2, tile_nodes = tile_edge * tile_edge * tile_edge;

inline int tile_index(Int3 n) { return (n.z * tile_edge + n.y) * tile_edge + n.x; }

// The nodes that a block's particles can reach, and one more for the end of the last row.
template <class R>
struct alignas(64) Tile {
    Node<R> node[tile_nodes + 1];
};

// Three neighbours along x. Where a register is wider than that, a fourth node is read with them
// and written back as it was: what is added to it is zero.
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
// Register by register: GCC copies more at once in pieces that the next load has to wait for.
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

// A particle's weights along x, each over a node's four numbers.
template <class R>
inline Row<R> weights_along_x(const Stencil<R>& s)
{
    const auto all = [](R w) { return four(Vec3<R>{w, w, w}, w); };
    return row(all(s.w[0].x), all(s.w[1].x), all(s.w[2].x));
}

// add(j, k, share): to the three nodes that stand j and k steps along y and z from the base.
// `base` holds momentum and mass, the others what it grows by from node to node.
template <class R, class Add>
inline void scatter_rows(Four<R> base, Four<R> by_x, Four<R> by_y, Four<R> by_z,
                         const Stencil<R>& s, Add&& add)
{
    const Row<R> w = weights_along_x(s), first = w * row(base, base + by_x, base + R(2) * by_x),
                 along_y = w * row(by_y, by_y, by_y), along_z = w * row(by_z, by_z, by_z);
    UNROLL
    for (int k = 0; k < 3; ++k) {
        const Row<R> plane = k ? first + R(k) * along_z : first;
        UNROLL
        for (int j = 0; j < 3; ++j)
            add(j, k, (s.w[k].z * s.w[j].y) * (j ? plane + R(j) * along_y : plane));
    }
}

// The sums of w v, and of w v times the step along x, y and z.
template <class R>
struct Gathered {
    Four<R> v, by_x, by_y, by_z;
};

// rows(j, k) answers with the velocities of those three nodes.
template <class R, class Rows>
inline Gathered<R> gather_rows(const Stencil<R>& s, Rows&& rows)
{
    Row<R> sum{}, sum_y{}, sum_z{};
    UNROLL
    for (int k = 0; k < 3; ++k) {
        const Row<R> second = s.w[1].y * rows(1, k), third = s.w[2].y * rows(2, k);
        const Row<R> plane = s.w[0].y * rows(0, k) + second + third;
        sum = sum + s.w[k].z * plane;
        sum_y = sum_y + s.w[k].z * (second + R(2) * third);
        if (k) sum_z = sum_z + (R(k) * s.w[k].z) * plane;
    }
    const Row<R> w = weights_along_x(s);
    const auto total = [](const Row<R>& a) {
        return node_of<0>(a) + node_of<1>(a) + node_of<2>(a);
    };
    sum = w * sum;
    return {total(sum), node_of<1>(sum) + R(2) * node_of<2>(sum), total(w * sum_y),
            total(w * sum_z)};
}

// The velocity's gradient around a particle from those sums; d is its way to the base node [m].
template <class R>
inline Mat3<R> velocity_gradient(Vec3<R> v, const Mat3<R>& by_step, Vec3<R> d, R dx)
{
    const R scale = 4 / (dx * dx);
    return {scale * (d.x * v + dx * by_step.a), scale * (d.y * v + dx * by_step.b),
            scale * (d.z * v + dx * by_step.c)};
}

}  // namespace knead
