// The 27 nodes around a particle: partition of unity, first and second moment, and that every
// stencil finds the nodes it should.
#include "cuda/mpm/stencil.h"

#include "tests/solver/samples.h"

namespace knead {
namespace {

template <class R>
class StencilTest : public ::testing::Test {
};
TYPED_TEST_SUITE(StencilTest, Scalars);

// A place in a lattice of 64 nodes of spacing dx, at times exactly between or on nodes.
template <class R>
Vec3<R> place(Draw& draw, R dx, int round)
{
    const Vec3<double> g{draw.in(2, 61), draw.in(2, 61), draw.in(2, 61)};
    const auto snap = [&](double t) { return std::round(2 * t) / 2; };
    const Vec3<double> at = round % 4 ? g : Vec3<double>{snap(g.x), snap(g.y), g.z};
    return cast<R>(double(dx) * at);
}

TYPED_TEST(StencilTest, WeightsAreAPartitionOfUnityAndNeverNegative)
{
    using R = TypeParam;
    Draw draw(1);
    for (int round = 0; round < 5000; ++round) {
        const R dx = R(draw.power(-4, 1));
        R sum = 0, min_weight = 1;
        for_each_node(stencil(place(draw, dx, round), dx), dx, [&](Int3, R w, Vec3<R>) {
            sum += w;
            min_weight = min(min_weight, w);
        });
        EXPECT_NEAR(double(sum), 1, either<R>(1e-6, 2e-15));
        EXPECT_GE(min_weight, 0);
    }
}

TYPED_TEST(StencilTest, FirstMomentVanishesAndSecondIsAQuarterOfACellSquared)
{
    using R = TypeParam;
    Draw draw(2);
    for (int round = 0; round < 5000; ++round) {
        const R dx = R(draw.power(-4, 1));
        Vec3<double> first{};
        Mat3<double> second{};
        for_each_node(stencil(place(draw, dx, round), dx), dx, [&](Int3, R w, Vec3<R> d) {
            const Vec3<double> offset = (1 / double(dx)) * cast<double>(d);
            first = first + double(w) * offset;
            second = second + double(w) * outer(offset, offset);
        });
        // In float a particle's place within its cell is known to 4e-6 of a cell at node 60.
        EXPECT_LT(length(first), either<R>(2e-5, 3e-14));
        EXPECT_LT(size(second - diagonal(0.25)), either<R>(4e-5, 6e-14));
    }
}

TYPED_TEST(StencilTest, NodesLieWithinOneAndAHalfCellsAndOffsetsLeadToThem)
{
    using R = TypeParam;
    Draw draw(3);
    for (int round = 0; round < 5000; ++round) {
        const R dx = R(draw.power(-4, 1));
        const Vec3<R> x = place(draw, dx, round);
        const Stencil<R> s = stencil(x, dx);
        EXPECT_TRUE(s.base == base_node(x, dx));
        int count = 0;
        for_each_node(s, dx, [&](Int3 step, R, Vec3<R> d) {
            const Int3 n = s.base + step;
            const Vec3<double> node =
                double(dx) * Vec3<double>{double(n.x), double(n.y), double(n.z)};
            EXPECT_LT(length(node - cast<double>(x) - cast<double>(d)),
                      dx * either<R>(2e-5, 3e-14));
            for (const R offset : {d.x, d.y, d.z})
                EXPECT_LE(std::abs(double(offset)), double(dx) * (1.5 + either<R>(1e-5, 1e-13)));
            EXPECT_EQ(step.x + 3 * (step.y + 3 * step.z), count++);
        });
        EXPECT_EQ(count, 27);
    }
}

TYPED_TEST(StencilTest, InterpolationReproducesAffineFields)
{
    using R = TypeParam;
    Draw draw(4);
    for (int round = 0; round < 3000; ++round) {
        const R dx = R(draw.power(-3, 0));
        const Vec3<R> x = place(draw, dx, round);
        const Vec3<double> constant = draw.vector(), slope = draw.vector();
        const Stencil<R> s = stencil(x, dx);
        double sum = 0;
        for_each_node(s, dx, [&](Int3 step, R w, Vec3<R>) {
            const Int3 n = s.base + step;
            sum += double(w) * (constant.x + n.x * slope.x + n.y * slope.y + n.z * slope.z);
        });
        const double expected = constant.x + dot((1 / double(dx)) * cast<double>(x), slope);
        EXPECT_NEAR(sum, expected, either<R>(3e-4, 3e-13));
    }
}

TYPED_TEST(StencilTest, WeightsAreContinuousWhereTheBaseNodeChanges)
{
    using R = TypeParam;
    const R dx = R(1) / 64, step = R(1e-5 * either<R>(1, 1e-6)) * dx;
    const R border = R(10.5) * dx;
    const auto weight_of_node_10 = [&](R x) {
        const Stencil<R> s = stencil(Vec3<R>{x, border, border}, dx);
        const int k = 10 - s.base.x;
        return k < 0 || k > 2 ? R(0) : s.w[k].x;
    };
    const R before = weight_of_node_10(border - step), after = weight_of_node_10(border + step);
    EXPECT_NEAR(double(before), 0.5, 1e-4);
    EXPECT_NEAR(double(before), double(after), 1e-4);
}

}  // namespace
}  // namespace knead
