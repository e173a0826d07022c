// What one particle hands over is its momentum but for rounding, which differs from particle to
// particle: no share of it is the same each time, which thousands of substeps would add up.
#include "cuda/mpm/p2g.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

// Of the motion within a cell, on average.
double kept_back(Material<float> m)
{
    const float dx = 0.01f, dt = 1e-4f;
    m.mu = 4e4f, m.lambda = 6e4f;
    Draw draw(7);
    const Mat3<double> C{{8, -15, -35}, {15, -3, 20}, {35, -20, 40}};
    constexpr int count = 100000;
    Vec3<double> off{};
    for (int k = 0; k < count; ++k) {
        Particle<float> q{};
        q.x = cast<float>(Vec3<double>{0.1, 0.1, 0.1} + draw.vector(0.05));
        q.v = cast<float>(draw.vector(0.4)), q.C = cast<float>(draw.in(0.9, 1.1) * C);
        Vec3<double> sum{};
        scatter(q, m, stencil(q.x, dx), dx, dt, [&](Int3, const Node<float>& share) {
            sum = sum + (1 / double(m.mass)) * cast<double>(share.p);
        });
        off = off + (1.0 / count) * (sum - cast<double>(q.v));
    }
    return length(off) / (40 * double(dx));
}

TEST(Momentum, RoundingFavoursNoSide)
{
    // Masses whose reciprocals are rounded up and down, by up to half of a float's last place.
    for (const double density : {1000.0, 1234.0, 1700.0, 917.0, 2650.0}) {
        Material<float> m{};
        m.density = float(density), m.volume = 1.25e-7f, m.mass = m.volume * m.density;
        EXPECT_LT(kept_back(m), 3e-9) << density;  // a float holds 6e-8
    }
}

}  // namespace
}  // namespace knead
