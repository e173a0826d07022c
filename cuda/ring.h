// The ring of a vertex, found from the edge of the lattice it lies on: its triangles belong to the
// four cells around that edge, so a vertex can ask for them and nothing is scattered to it.
#pragma once
#include "march_table.h"
#include "vec.h"

namespace knead {

// Most triangles of one cell that meet in its edge e.
constexpr int most_triangles_at(int e)
{
    int most_of_any = 0;
    for (int inside = 0; inside < 256; ++inside) {
        int here = 0;
        for (int k = 0; k < 3 * march_table.count[inside]; ++k)
            here += march_table.edge[inside][k] == e;
        most_of_any = most_of_any < here ? here : most_of_any;
    }
    return most_of_any;
}

// No vertex has more triangles than this.
constexpr int derive_most_ring()
{
    int largest = 0;
    for (int axis = 0; axis < 3; ++axis) {
        int sum = 0;
        for (int k = 0; k < 4; ++k) sum += most_triangles_at(4 * axis + k);
        largest = largest < sum ? sum : largest;
    }
    return largest;
}
constexpr int most_ring = derive_most_ring();

// Calls take(next, last) for every triangle around the vertex on a node's edge along `axis`: its
// other two vertices, counter-clockwise. Cells are named by the corner of theirs that the node is:
// case_of(corner) is such a cell's case, vertex(corner, e) the vertex on its edge e.
template <class Case, class Vertex, class Take>
HD void for_each_around(int axis, const MarchTable& table, Case&& case_of, Vertex&& vertex,
                        Take&& take)
{
    for (int k = 0; k < 4; ++k) {
        const int e = 4 * axis + k, corner = low_corner(e), inside = case_of(corner);
        for (int t = 0; t < table.count[inside]; ++t) {
            const std::uint8_t* const edge = table.edge[inside] + 3 * t;
            if (edge[0] == e) take(vertex(corner, edge[1]), vertex(corner, edge[2]));
            if (edge[1] == e) take(vertex(corner, edge[2]), vertex(corner, edge[0]));
            if (edge[2] == e) take(vertex(corner, edge[0]), vertex(corner, edge[1]));
        }
    }
}

}  // namespace knead
