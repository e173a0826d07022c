// What makes a mesh a closed surface, read off its triangles alone.
#pragma once
#include <array>
#include <map>
#include <set>
#include <string>

#include "host/surface/mesh.h"

namespace knead {

// Empty if the mesh is a closed manifold, else what is wrong with it first.
inline std::string fault(const Mesh& m)
{
    const int vertices = int(m.vertices.size());
    std::map<std::pair<int, int>, int> edges;  // directed, with the triangle's third
    std::vector<std::map<int, int>> around(m.vertices.size());  // per vertex: from one to the next
    for (const Int3 t : m.triangles) {
        const int corner[3] = {t.x, t.y, t.z};
        for (int k = 0; k < 3; ++k) {
            const int a = corner[k], b = corner[(k + 1) % 3], c = corner[(k + 2) % 3];
            if (a < 0 || a >= vertices) return "a triangle has a vertex that is not there";
            if (a == b) return "a triangle has a vertex twice";
            if (!edges.emplace(std::pair{a, b}, c).second) return "an edge runs the same way twice";
            around[std::size_t(a)][b] = c;
        }
    }
    for (const auto& [edge, third] : edges)
        if (!edges.contains({edge.second, edge.first})) return "an edge has one triangle";
    for (const auto& ring : around) {
        if (ring.empty()) return "a vertex is unused";
        std::size_t turns = 0;
        int at = ring.begin()->first;
        do at = ring.at(at), ++turns;
        while (at != ring.begin()->first && turns <= ring.size());
        if (turns != ring.size()) return "two fans meet in one vertex";
    }
    std::set<std::array<float, 3>> places;
    for (const Vec3<float> x : m.vertices)
        if (!places.insert({x.x, x.y, x.z}).second) return "two vertices are in one place";
    return "";
}

inline int euler(const Mesh& m)  // of a closed mesh: 3 triangles have 2 edges each of their own
{
    return int(m.vertices.size()) - int(m.triangles.size()) / 2;
}

}  // namespace knead
