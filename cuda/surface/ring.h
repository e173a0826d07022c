// The ring of a vertex, found from the lattice edge that it lies on: its triangles belong to the
// four cells around that edge, so vertices gather them and nothing is scattered.
#pragma once
#include <cstdint>

#include "cuda/math/vec.h"
#include "cuda/surface/march_table.h"

namespace knead {

// The largest number of triangles of one cell at its edge e.
constexpr int max_triangles_at(int e)
{
    int max_of_any = 0;
    for (int inside = 0; inside < 256; ++inside) {
        int here = 0;
        for (int k = 0; k < 3 * march_table.count[inside]; ++k)
            here += march_table.edge[inside][k] == e;
        max_of_any = max_of_any < here ? here : max_of_any;
    }
    return max_of_any;
}

// Upper bound of the triangles at a vertex.
constexpr int derive_max_ring()
{
    int largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        int sum = 0;
        for (int k = 0; k < 4; ++k) sum += max_triangles_at(4 * axis + k);
        largest = largest < sum ? sum : largest;
    }
    return largest;
}
constexpr int max_ring = derive_max_ring();

// Calls take(next, last) for every triangle of a cell of case `inside` that has a vertex on its
// edge e: its other two, counter-clockwise; vertex(e) is the vertex on an edge of the cell.
template <class Vertex, class Take>
HD void for_each_at(int e, int inside, const MarchTable& table, Vertex&& vertex, Take&& take)
{
    for (int t = 0; t < table.count[inside]; ++t) {
        const std::uint8_t* const edge = table.edge[inside] + 3 * t;
        const int a = edge[0], b = edge[1], c = edge[2];
        if (a == e) take(vertex(b), vertex(c));
        if (b == e) take(vertex(c), vertex(a));
        if (c == e) take(vertex(a), vertex(b));
    }
}

// The four cells around a node's edge along `axis`: the corner of each cell at which the node is,
// and the edge of each cell that coincides with the node's edge.
HD int edge_of_cell(int axis, int k) { return 4 * axis + k; }
HD int corner_of_cell(int axis, int k) { return low_corner(edge_of_cell(axis, k)); }

}  // namespace knead
