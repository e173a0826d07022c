// How evenly the clay of a scene's first object is filled.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "cuda/mpm/stencil.h"
#include "host/scene/shapes.h"

namespace knead {

// Standard deviation of the density at the nodes at least 1.5 cells below the surface, whose
// particles are all inside, as a share of the mean.
inline double density_noise(const Scene& s)
{
    const auto& lattice = s.setup.lattice;
    const double dx = lattice.dx;
    std::vector<double> mass(std::size_t(lattice.size.x) * std::size_t(lattice.size.y) *
                             std::size_t(lattice.size.z));
    const auto at = [&](Int3 n) {
        return std::size_t((n.z * lattice.size.y + n.y) * lattice.size.x + n.x);
    };
    for (const Particle<double>& p : s.setup.particles) {
        const Stencil<double> near = stencil((1 / dx) * p.x, 1.0);
        for_each_node(near, 1.0,
                      [&](Int3 step, double w, Vec3<double>) { mass[at(near.base + step)] += w; });
    }
    double sum = 0, square = 0, count = 0;
    for (int z = 0; z < lattice.size.z; ++z)
        for (int y = 0; y < lattice.size.y; ++y)
            for (int x = 0; x < lattice.size.x; ++x) {
                const Vec3<double> node = dx * Vec3<double>{double(x), double(y), double(z)};
                if (depth(s.objects[0], node) < 1.5 * dx) continue;
                const double m = mass[at({x, y, z})];
                sum += m, square += m * m, ++count;
            }
    EXPECT_GT(count, 500);
    const double mean = sum / count;
    EXPECT_NEAR(mean, 8, 0.01);
    return std::sqrt(std::max(0.0, square / count - mean * mean)) / mean;
}

}  // namespace knead
