// Whether two results are equal to the bit, whatever their numbers mean.
#pragma once
#include <algorithm>
#include <cstring>
#include <vector>

#include "host/surface/mesh.h"

namespace knead {

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b)
{
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}
inline bool same_bits(const std::vector<Mesh>& a, const std::vector<Mesh>& b)
{
    return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Mesh& m, const Mesh& n) {
        return m.category == n.category && same_bits(m.vertices, n.vertices) &&
               same_bits(m.normals, n.normals) && same_bits(m.triangles, n.triangles);
    });
}

}  // namespace knead
