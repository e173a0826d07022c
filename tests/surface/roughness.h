// How rough a surface is, read off its mesh alone: distances of vertices from what a smooth skin
// would be, a sphere where clay was one, elsewhere the quadric that fits the vertices around best.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "host/base/parallel.h"
#include "host/surface/mesh.h"

namespace knead {

struct Roughness {
    double rms = 0, max = 0;
    std::size_t vertices = 0;
};

inline Roughness roughness_of(const std::vector<double>& distances)
{
    Roughness r;
    for (const double d : distances)
        r.rms += d * d, r.max = std::max(r.max, std::abs(d)), ++r.vertices;
    r.rms = std::sqrt(r.rms / std::max<double>(1, double(r.vertices)));
    return r;
}

// The weights of N terms that give the values best; add(terms, value) for each. Normal equations.
template <std::size_t N>
class LeastSquares {
  public:
    void add(const std::array<double, N>& terms, double value)
    {
        for (std::size_t i = 0; i < N; ++i) {
            for (std::size_t j = 0; j < N; ++j) rows[i][j] += terms[i] * terms[j];
            rows[i][N] += terms[i] * value;
        }
    }
    std::array<double, N> solved()
    {
        for (std::size_t i = 0; i < N; ++i) {
            std::size_t pivot = i;
            for (std::size_t k = i; k < N; ++k)
                if (std::abs(rows[k][i]) > std::abs(rows[pivot][i])) pivot = k;
            std::swap(rows[i], rows[pivot]);
            for (std::size_t k = 0; k < N; ++k) {
                if (k == i) continue;
                const double factor = rows[k][i] / rows[i][i];
                for (std::size_t j = i; j <= N; ++j) rows[k][j] -= factor * rows[i][j];
            }
        }
        std::array<double, N> weights;
        for (std::size_t i = 0; i < N; ++i) weights[i] = rows[i][N] / rows[i][i];
        return weights;
    }

  private:
    std::array<std::array<double, N + 1>, N> rows{};
};

// Signed distances from the sphere that fits all vertices best [m].
inline std::vector<double> from_sphere(const Mesh& mesh)
{
    const Vec3<double> about = cast<double>(mesh.vertices.at(0));
    LeastSquares<4> fit;
    for (const Vec3<float> v : mesh.vertices) {
        const Vec3<double> x = cast<double>(v) - about;
        fit.add({x.x, x.y, x.z, 1}, dot(x, x));
    }
    const auto [a, b, c, d] = fit.solved();
    const Vec3<double> centre = 0.5 * Vec3<double>{a, b, c};
    const double radius = std::sqrt(d + dot(centre, centre));
    std::vector<double> distances;
    for (const Vec3<float> v : mesh.vertices)
        distances.push_back(length(cast<double>(v) - about - centre) - radius);
    return distances;
}

// Vertices by the cube of edge `reach` that they are in.
class Nearby {
  public:
    Nearby(const Mesh& of, double within) : mesh(of), reach(within)
    {
        for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
            cubes[key(cube_of(cast<double>(mesh.vertices[v])))].push_back(v);
    }
    // Calls visit(vertex) for those within `reach` of x.
    template <class Visit>
    void each(Vec3<double> x, Visit&& visit) const
    {
        for (int k = 0; k < 27; ++k) {
            const Int3 at = cube_of(x) + Int3{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
            const auto found = cubes.find(key(at));
            if (found == cubes.end()) continue;
            for (const std::size_t v : found->second)
                if (length(cast<double>(mesh.vertices[v]) - x) < reach) visit(v);
        }
    }

  private:
    Int3 cube_of(Vec3<double> x) const
    {
        return {int(std::floor(x.x / reach)), int(std::floor(x.y / reach)),
                int(std::floor(x.z / reach))};
    }
    static std::int64_t key(Int3 c)
    {
        return (std::int64_t(c.x) << 42) + (std::int64_t(c.y) << 21) + c.z;
    }

    const Mesh& mesh;
    double reach;
    std::unordered_map<std::int64_t, std::vector<std::size_t>> cubes;
};

// Signed distances of the vertices from the quadric that fits those within `reach` best [m], of the
// same side of thin clay; needs normals. Of a sphere of radius R this finds reach^4 / (48 R^3).
inline std::vector<double> from_quadric(const Mesh& mesh, double reach)
{
    const Nearby nearby(mesh, reach);
    std::vector<double> distances(mesh.vertices.size());
    parallel_for(mesh.vertices.size(), LoopOptions{.chunk = 64}, [&](std::size_t v) {
        const Vec3<double> x = cast<double>(mesh.vertices[v]);
        const Vec3<double> n = cast<double>(mesh.normals[v]), a = orthogonal(n), b = cross(n, a);
        LeastSquares<6> fit;
        nearby.each(x, [&](std::size_t other) {
            if (dot(cast<double>(mesh.normals[other]), n) < 0.3) return;
            const Vec3<double> d = (1 / reach) * (cast<double>(mesh.vertices[other]) - x);
            const double s = dot(d, a), t = dot(d, b);
            fit.add({1, s, t, s * s, s * t, t * t}, dot(d, n));
        });
        const auto weights = fit.solved();
        distances[v] = -reach * weights[0] / std::hypot(1.0, weights[1], weights[2]);
    });
    return distances;
}

}  // namespace knead
