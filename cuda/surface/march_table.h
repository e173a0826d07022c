// The 256 cases of marching cubes, computed at compile time.  [Lorensen 1987]
//
// Corner c of a cell has x in bit 0, y in bit 1, z in bit 2. Edge e runs along axis e / 4; bits 0
// and 1 of e are its position along the next two axes, cyclically. A corner is inside or outside.
//
// On each face the surface has a curve around every run of inside corners: two inside corners on a
// diagonal each get their own curve. The curves depend on the face only, so they are equal in the
// two cells that share the face, and the surface has no hole. The curves of six faces close into
// loops, and each loop is split into a fan none of whose diagonals lies in a face. So the two cells
// of a face never both draw an edge inside it, and every edge of the mesh has exactly two
// triangles.
#pragma once
#include <cstdint>

#include "cuda/math/hd.h"

namespace knead {

constexpr int cell_edges = 12, max_cell_triangles = 5;

struct MarchTable {
    std::uint8_t count[256];                         // triangles of the case
    std::uint8_t edge[256][3 * max_cell_triangles];  // three edges each, counter-clockwise seen
                                                     // from outside
    bool sound;  // every loop has such a fan, and the triangles fit
};

// Corner at the low end of edge e; the other end is one step along axis e / 4.
HD constexpr int low_corner(int e)
{
    const int next = (e / 4 + 1) % 3, last = (e / 4 + 2) % 3;
    return (e & 1) << next | (e >> 1 & 1) << last;
}

constexpr int edge_between(int corner, int other)
{
    const int along = corner ^ other, low = corner & other;
    const int axis = along == 1 ? 0 : along == 2 ? 1 : 2;
    return 4 * axis + (low >> (axis + 1) % 3 & 1) + 2 * (low >> (axis + 2) % 3 & 1);
}

// The two faces an edge lies in, as bits 2 * axis + side.
constexpr unsigned faces_of(int e)
{
    const int next = (e / 4 + 1) % 3, last = (e / 4 + 2) % 3;
    return 1u << (2 * next + (e & 1)) | 1u << (2 * last + (e >> 1 & 1));
}

// A closed curve on the faces of a cell: the edges it passes, in order.
struct CellLoop {
    int edge[cell_edges] = {}, length = 0;
};

// The successor of each edge on the curve: the edge at the end of the run of inside corners,
// walking around each face counter-clockwise seen from outside the cell.
struct CellCurves {
    int next[cell_edges] = {};
};
constexpr CellCurves curves_of(int inside)
{
    CellCurves curves;
    for (int& next : curves.next) next = -1;
    for (int face = 0; face < 6; ++face) {
        const int axis = face / 2, side = face % 2, base = side << axis;
        const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3;
        const int around[4] = {base, base | (side ? u : v), base | u | v, base | (side ? v : u)};
        const auto in = [&](int k) { return (inside >> around[k % 4] & 1) != 0; };
        for (int k = 0; k < 4; ++k) {
            if (in(k) || !in(k + 1)) continue;
            int end = k + 1;
            while (in(end + 1)) ++end;
            curves.next[edge_between(around[k], around[(k + 1) % 4])] =
                edge_between(around[end % 4], around[(end + 1) % 4]);
        }
    }
    return curves;
}

constexpr bool fan_avoids_faces(const CellLoop& loop, int start)
{
    for (int k = 2; k + 1 < loop.length; ++k)
        if (faces_of(loop.edge[start]) & faces_of(loop.edge[(start + k) % loop.length]))
            return false;
    return true;
}

constexpr bool add_fan(MarchTable& table, int inside, const CellLoop& loop)
{
    int start = 0;
    while (start < loop.length && !fan_avoids_faces(loop, start)) ++start;
    if (start == loop.length || table.count[inside] + loop.length - 2 > max_cell_triangles)
        return false;
    const auto edge = [&](int k) {
        return static_cast<std::uint8_t>(loop.edge[(start + k) % loop.length]);
    };
    for (int k = 1; k + 1 < loop.length; ++k) {
        std::uint8_t* const triangle = table.edge[inside] + 3 * table.count[inside]++;
        triangle[0] = edge(0), triangle[1] = edge(k), triangle[2] = edge(k + 1);
    }
    return true;
}

constexpr MarchTable derive_march_table()
{
    MarchTable table{};
    table.sound = true;
    for (int inside = 0; inside < 256; ++inside) {
        CellCurves curves = curves_of(inside);
        for (int first = 0; first < cell_edges; ++first) {
            CellLoop loop;
            for (int e = first; curves.next[e] >= 0;) {
                loop.edge[loop.length++] = e;
                const int next = curves.next[e];
                curves.next[e] = -1;
                e = next;
            }
            if (loop.length) table.sound = add_fan(table, inside, loop) && table.sound;
        }
    }
    return table;
}

inline constexpr MarchTable march_table = derive_march_table();
static_assert(march_table.sound);

}  // namespace knead
