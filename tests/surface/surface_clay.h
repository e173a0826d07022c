// Clay to make surfaces of.
#pragma once
#include <limits>
#include <vector>

#include "host/surface/surface.h"
#include "tests/solver/samples.h"

namespace knead {

// Particles, one per h^3, jittered over a shape.
template <class Inside>
std::vector<Particle<double>> filled(double h, unsigned seed, int object, Inside&& is_in)
{
    Draw draw(seed);
    std::vector<Particle<double>> particles;
    const int n = int(1 / h);
    for (int i = 0; i < n * n * n; ++i) {
        const Vec3<double> cell{double(i % n), double(i / n % n), double(i / (n * n))};
        const Vec3<double> jitter{draw.in(0, 1), draw.in(0, 1), draw.in(0, 1)};
        Particle<double> q{};
        q.x = h * (cell + jitter);
        q.object = object;
        if (is_in(q.x)) particles.push_back(q);
    }
    return particles;
}
inline auto ball(Vec3<double> centre, double radius)
{
    return [=](Vec3<double> x) { return length(x - centre) < radius; };
}

inline Material<double> clay(double h, int category = 0)
{
    Material<double> m{};
    m.density = 1500;
    m.volume = h * h * h;
    m.mass = m.density * m.volume;
    m.category = category;
    return m;
}

// A ball, one particle per h^3, and before it particles that no surface can use: seven without a
// position or a material of any volume, two outside of the lattice.
struct Mixed {
    std::vector<Particle<double>> good, all;
    std::vector<Material<double>> materials;
};
inline Mixed mixed(double h)
{
    Mixed m{filled(h, 3, 0, ball({0.5, 0.5, 0.5}, 0.3)), {}, {clay(h), clay(h), clay(h)}};
    m.materials[1].mass = 0;
    m.materials[2].density = 0;
    const auto add = [&](Vec3<double> x, int object) {
        Particle<double> q{};
        q.x = x, q.object = object;
        m.all.push_back(q);
    };
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const double huge = std::numeric_limits<double>::infinity();
    add({nan, 0.5, 0.5}, 0), add({0.5, huge, 0.5}, 0), add({0.5, 0.5, 1e300}, 0);
    add({0.5, 0.5, 0.5}, -1), add({0.5, 0.5, 0.5}, 3), add({0.5, 0.5, 0.5}, 1);
    add({0.5, 0.5, 0.5}, 2);
    add({-0.1, 0.5, 0.5}, 0), add({0.5, 1e20, 0.5}, 0);
    m.all.insert(m.all.end(), m.good.begin(), m.good.end());
    return m;
}

inline SurfaceOptions rule_of(int nodes, Smoothing smoothing = Smoothing::taubin)
{
    SurfaceOptions options;
    options.lattice = {{nodes, nodes, nodes}, 1.0f / float(nodes)};
    options.smoothing = smoothing;
    return options;
}

}  // namespace knead
