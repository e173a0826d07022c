// Few particles: what tells a crumb, and what is done about it.
#include <cmath>
#include <vector>

#include "cuda/mpm/g2p.h"
#include "cuda/mpm/p2g.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

template <class R>
class CrumbTest : public ::testing::Test {
};
TYPED_TEST_SUITE(CrumbTest, Scalars);

// A lattice that particles at rest, two an axis and cell, have given their mass to.
template <class R>
struct Weighed {
    Lattice<R> lattice{{12, 12, 12}, R(1) / 12};
    Material<R> material{};
    std::vector<Node<R>> nodes;

    // Cubes of so many particles an edge, from a corner on.
    Weighed(Vec3<R> corner, int edge) : nodes(std::size_t(lattice.node_count()))
    {
        material.density = 1000;
        material.volume = R(std::pow(double(lattice.dx) / 2, 3));
        material.mass = material.volume * material.density;
        for (int i = 0; i < edge * edge * edge; ++i) {
            Particle<R> q{};
            q.x = corner +
                  lattice.dx / 2 * Vec3<R>{R(i % edge), R(i / edge % edge), R(i / (edge * edge))};
            const Stencil<R> s = stencil(q.x, lattice.dx);
            scatter(q, material, s, lattice.dx, R(0), [&](Int3 step, const Node<R>& share) {
                nodes[std::size_t(lattice.index(s.base + step))].m += share.m;
            });
        }
    }
    double per_cell(Vec3<R> x) const
    {
        Particle<R> q{};
        const Stencil<R> s = stencil(x, lattice.dx);
        const auto sum = gather(q, s, lattice.dx, [&](Int3 step) {
            return four(nodes[std::size_t(lattice.index(s.base + step))]);
        });
        return double(mass_around(sum) / material.mass);
    }
};

// Wherever it is between the nodes. The nearest node has the mass of 0.24 to 6.5 particles at a
// body's corner, as those fall.
TYPED_TEST(CrumbTest, TheMassAroundAParticleTellsItFromTheCornerOfABody)
{
    using R = TypeParam;
    Draw draw(11);
    for (int round = 0; round < 100; ++round) {
        const Vec3<R> corner = cast<R>(Vec3<double>{0.25, 0.25, 0.25} + 0.04 * draw.vector());
        const double lone = Weighed<R>(corner, 1).per_cell(corner);
        EXPECT_TRUE(lone > 0.1249 && lone < 0.2094) << lone;
        constexpr int edge = 14;
        const Weighed<R> body(corner, edge);
        const double outermost = body.per_cell(corner);
        EXPECT_TRUE(outermost > 1.86 && outermost < 2.30) << outermost;
        const R inside = R(edge - 1) / 4 * body.lattice.dx;
        EXPECT_NEAR(body.per_cell(corner + Vec3<R>{inside, inside, inside}), 8,
                    either<R>(1e-4, 1e-12));
    }
}

// An oscillator by itself, of the stiffest kind, in substeps longer than its limit: a crumb's does
// not grow; what belongs to a body is left as it was.
TYPED_TEST(CrumbTest, IsCalmedAndABodyIsNot)
{
    using R = TypeParam;
    Draw draw(10);
    for (int round = 0; round < 100; ++round) {
        const Mat3<R> C = cast<R>(draw.matrix());
        Mat3<R> body = C, crumb = C;
        damp_isolated_particle(body, R(draw.in(1, 20)));
        EXPECT_EQ(size(body - C), 0);
        damp_isolated_particle(crumb,
                               R(draw.in(0.125, 0.43)));  // one particle, anywhere in its cell
        EXPECT_LT(size(skew(crumb) - skew(C)), either<R>(1e-6, 1e-15));
        const double left = size(symmetric(crumb)) / size(symmetric(C));
        EXPECT_GT(left, 0.18);
        EXPECT_LT(left, 0.27);
        const double times = 1.5, grows = 4 * times * times;  // of the limit (22)
        double rate = 1, strain = 0, most = 0;
        for (int n = 0; n < 1000; ++n) {
            rate = left * (rate - grows * strain), strain += rate;
            most = std::fmax(most, std::fabs(strain));
        }
        EXPECT_LE(most, 1);
    }
}

}  // namespace
}  // namespace knead
