// A regular grid of nodes for fields over an object, x fastest.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "cuda/math/vec.h"

namespace knead {

struct Grid {
    Vec3<double> origin{};  // position of node (0, 0, 0) [m]
    double h = 1;           // spacing [m]
    Int3 size{};            // nodes along each axis, at least 2

    std::size_t count() const { return std::size_t(size.x) * size.y * size.z; }
    std::size_t at(Int3 n) const
    {
        return n.x + std::size_t(size.x) * (n.y + std::size_t(size.y) * n.z);
    }
    Int3 node(std::size_t i) const
    {
        const std::size_t row = i / size.x;
        return {int(i % size.x), int(row % size.y), int(row / size.y)};
    }
    Vec3<double> position(Int3 n) const
    {
        return origin + h * Vec3<double>{double(n.x), double(n.y), double(n.z)};
    }
    Vec3<double> local(Vec3<double> x) const { return (1 / h) * (x - origin); }  // [h]
    bool within(Int3 n, int rim = 0) const  // outside the outermost `rim` layers
    {
        return n.x >= rim && n.y >= rim && n.z >= rim && n.x < size.x - rim && n.y < size.y - rim &&
               n.z < size.z - rim;
    }
};

// Trilinear interpolation of the field at x; clamped to the boundary outside the box.
template <class T>
T sampled(const Grid& grid, const std::vector<T>& field, Vec3<double> x)
{
    const Vec3<double> u = grid.local(x);
    struct Place {
        int low;
        float share;  // weight of the higher node
    };
    const auto place = [](double at, int nodes) {
        const double inner = clamp(at, 0.0, double(nodes - 1));
        const int low = std::min(int(inner), nodes - 2);
        return Place{low, float(inner - low)};
    };
    const Place a = place(u.x, grid.size.x), b = place(u.y, grid.size.y),
                c = place(u.z, grid.size.z);
    const auto along_x = [&](int y, int z) {
        const T* row = &field[grid.at({a.low, b.low + y, c.low + z})];
        return (1 - a.share) * row[0] + a.share * row[1];
    };
    const auto along_y = [&](int z) {
        return (1 - b.share) * along_x(0, z) + b.share * along_x(1, z);
    };
    return (1 - c.share) * along_y(0) + c.share * along_y(1);
}

}  // namespace knead
