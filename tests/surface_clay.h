// Clay to make surfaces of.
#pragma once
#include <vector>

#include "host/surface.h"
#include "samples.h"

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

inline SurfaceRule rule_of(int nodes, Smoothing smoothing = Smoothing::taubin)
{
    SurfaceRule rule;
    rule.lattice = {{nodes, nodes, nodes}, 1.0f / float(nodes)};
    rule.smoothing = smoothing;
    return rule;
}

}  // namespace knead
