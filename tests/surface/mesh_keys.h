// Which edge of the lattice each vertex of an unsmoothed surface lies on: what tells two meshes of
// one density whose vertices are named differently that they are the same.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <vector>

#include "host/surface/mesh.h"

namespace knead {

using EdgeKey = std::array<int, 4>;  // the node at the low end, and the axis

inline std::vector<EdgeKey> edge_keys(const Mesh& mesh, float dx)
{
    std::vector<EdgeKey> keys;
    for (const Vec3<float> v : mesh.vertices) {
        const double x[3] = {double(v.x) / dx, double(v.y) / dx, double(v.z) / dx};
        EdgeKey key{};
        double farthest = -1;  // vertices keep 1/64 of an edge from its ends
        for (int axis = 0; axis < 3; ++axis) {
            key[std::size_t(axis)] = int(std::lround(x[axis]));
            const double off = std::fabs(x[axis] - std::round(x[axis]));
            if (off > farthest) farthest = off, key[3] = axis;
        }
        key[std::size_t(key[3])] = int(std::floor(x[key[3]]));
        keys.push_back(key);
    }
    return keys;
}

// Every triangle by the edges of its corners, the least first.
inline std::set<std::array<EdgeKey, 3>> triangle_keys(const Mesh& m,
                                                      const std::vector<EdgeKey>& keys)
{
    std::set<std::array<EdgeKey, 3>> all;
    for (const Int3 t : m.triangles) {
        std::array<EdgeKey, 3> corners{keys[std::size_t(t.x)], keys[std::size_t(t.y)],
                                       keys[std::size_t(t.z)]};
        std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()),
                    corners.end());
        all.insert(corners);
    }
    return all;
}

// Both meshes unsmoothed. For every vertex of the first, the one of the second on the same edge.
inline std::vector<std::size_t> matched(const Mesh& a, const Mesh& b, float dx)
{
    const std::vector<EdgeKey> keys = edge_keys(a, dx), others = edge_keys(b, dx);
    EXPECT_EQ(triangle_keys(a, keys), triangle_keys(b, others));
    std::map<EdgeKey, std::size_t> place;
    for (std::size_t v = 0; v < others.size(); ++v) place[others[v]] = v;
    EXPECT_EQ(place.size(), keys.size());
    std::vector<std::size_t> match;
    for (const EdgeKey& key : keys) {
        const auto found = place.find(key);
        EXPECT_NE(found, place.end());
        match.push_back(found == place.end() ? 0 : found->second);
    }
    return match;
}

}  // namespace knead
