// The surface: density, the table of cases, closedness, volume, smoothing, and the same bits from
// any number of threads.
#include "host/surface/surface.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <stdexcept>

#include "cuda/surface/density.h"
#include "cuda/surface/march.h"
#include "cuda/surface/smooth.h"
#include "tests/solver/samples.h"
#include "tests/surface/closed_mesh.h"

namespace knead {
namespace {

constexpr double pi = 3.14159265358979323846;

Field empty_box(Int3 size, float dx = 1)
{
    return {{0, 0, 0}, size, dx, std::vector<float>(std::size_t(size.x * size.y * size.z), 0.0f)};
}
float& at(Field& f, int x, int y, int z) { return f.value[(z * f.size.y + y) * f.size.x + x]; }

// A field that falls by one per metre through 1/2 at the surface of a shape, where one is inside.
template <class Distance>
Field field_of(int nodes, Distance&& distance)
{
    Field f = empty_box({nodes, nodes, nodes}, 1.0f / float(nodes - 1));
    for (int z = 1; z < nodes - 1; ++z)
        for (int y = 1; y < nodes - 1; ++y)
            for (int x = 1; x < nodes - 1; ++x)
                at(f, x, y, z) = float(
                    0.5 - distance(double(f.dx) * Vec3<double>{double(x), double(y), double(z)}));
    return f;
}

template <class R>
class Surface : public ::testing::Test {
};
TYPED_TEST_SUITE(Surface, Scalars);

TYPED_TEST(Surface, DepositKeepsVolumeAndItsCentre)
{
    using R = TypeParam;
    Draw draw(3);
    for (int round = 0; round < 200; ++round) {
        const R dx = R(draw.in(0.01, 0.1)), share = R(draw.in(0.1, 3));
        const Vec3<R> x = cast<R>(Vec3<double>{draw.in(1, 2), draw.in(1, 2), draw.in(1, 2)});
        const Stencil<R> s = stencil(x, dx);
        double sum = 0;
        Vec3<double> centre{};
        deposit(s, share, [&](Int3 step, R part) {
            const Int3 n = s.base + step;
            EXPECT_GE(part, 0);
            sum += double(part);
            centre = centre + double(part) * double(dx) *
                                  Vec3<double>{double(n.x), double(n.y), double(n.z)};
        });
        EXPECT_NEAR(sum, double(share), either<R>(1e-4, 1e-12));
        EXPECT_LT(length((1 / sum) * centre - cast<double>(x)), either<R>(1e-4, 1e-12));
    }
}

TYPED_TEST(Surface, CrossingIsWhereTheDensityIsIsoAndTheSameFromBothEnds)
{
    using R = TypeParam;
    Draw draw(4);
    for (int round = 0; round < 1000; ++round) {
        const R iso = R(0.5), a = R(draw.in(0, 0.5)), b = R(draw.in(0.51, 2));
        const R up = crossing(a, b, iso), down = crossing(b, a, iso);
        EXPECT_NEAR(up + down, 1, either<R>(1e-6, 1e-14));
        if (up > R(0.02) && up < R(0.98)) {
            EXPECT_NEAR(a + up * (b - a), iso, either<R>(1e-6, 1e-14));
        }
        EXPECT_GE(up, R(1) / 64);
        EXPECT_LE(up, R(63) / 64);
    }
    const R huge = std::numeric_limits<R>::infinity();
    EXPECT_EQ(crossing(R(0), huge, R(0.5)), R(1) / 64);
    EXPECT_EQ(crossing(huge, R(0), R(0.5)), R(63) / 64);
}

TYPED_TEST(Surface, ExactlyIsoIsOutsideAndSoIsNaN)
{
    using R = TypeParam;
    EXPECT_FALSE(is_inside(R(0.5), R(0.5)));
    EXPECT_TRUE(is_inside(std::nextafter(R(0.5), R(1)), R(0.5)));
    EXPECT_FALSE(is_inside(std::numeric_limits<R>::quiet_NaN(), R(0.5)));
}

TYPED_TEST(Surface, InsideTheLatticeMeansAllTwentySevenNodes)
{
    using R = TypeParam;
    const Lattice<R> l{{8, 12, 16}, R(0.25)};
    const auto nan = std::numeric_limits<R>::quiet_NaN();
    EXPECT_TRUE(inside(Vec3<R>{R(0.125), R(0.125), R(0.125)}, l));
    EXPECT_TRUE(inside(Vec3<R>{R(1.62), R(2.62), R(3.62)}, l));
    EXPECT_FALSE(inside(Vec3<R>{R(0.12), 1, 1}, l));
    EXPECT_FALSE(inside(Vec3<R>{R(1.63), 1, 1}, l));
    EXPECT_FALSE(inside(Vec3<R>{1, 1, R(3.63)}, l));
    EXPECT_FALSE(inside(Vec3<R>{1, nan, 1}, l));
    EXPECT_FALSE(inside(Vec3<R>{-R(1e30), 1, 1}, l));
}

TYPED_TEST(Surface, RelaxedVertexOfAFlatRingStaysAndASpikeIsHalved)
{
    using R = TypeParam;
    const Vec3<R> ring[4] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
    const auto neighbour = [&](int k) { return ring[k]; };
    EXPECT_EQ(relax(Vec3<R>{0, 0, 0}, 4, smooth_shrink<R>, neighbour).z, R(0));
    EXPECT_EQ(relax(Vec3<R>{0, 0, 2}, 4, smooth_shrink<R>, neighbour).z, R(1));
    EXPECT_EQ(relax(Vec3<R>{3, 0, 0}, 0, smooth_shrink<R>, neighbour).x, R(3));
}

TEST(SurfaceTable, EveryOneOfThe256CasesAloneIsAClosedManifold)
{
    for (int inside = 0; inside < 256; ++inside) {
        Field f = empty_box({4, 4, 4});
        for (int c = 0; c < 8; ++c)
            at(f, 1 + (c & 1), 1 + (c >> 1 & 1), 1 + (c >> 2)) = float(inside >> c & 1);
        const Mesh m = isosurface(f, 0.5f);
        EXPECT_EQ(fault(m), "") << "case " << inside;
        EXPECT_EQ(m.triangles.empty(), inside == 0);
        EXPECT_GE(volume(m), inside ? 0.1 : 0.0) << "case " << inside;
    }
}

TEST(SurfaceTable, RandomNodesMeetInAClosedManifold)
{
    Draw draw(9);
    for (int round = 0; round < 60; ++round) {
        Field f = empty_box({12, 10, 9});
        const double share = draw.in(0.05, 0.95);
        for (int z = 1; z < 8; ++z)
            for (int y = 1; y < 9; ++y)
                for (int x = 1; x < 11; ++x)
                    at(f, x, y, z) =
                        float(draw.in(0, 1) < share ? draw.in(0.5, 3) : draw.in(0, 0.5));
        const Mesh m = isosurface(f, 0.5f);
        EXPECT_EQ(fault(m), "");
        EXPECT_GT(volume(m), 0);
    }
}

TEST(SurfaceTable, NodesExactlyAtIsoMakeNoHoleAndNoDoubleVertex)
{
    Draw draw(10);
    const float values[] = {0, 0.5f, 1, std::nextafter(0.5f, 1.0f), 1e30f};
    for (int round = 0; round < 60; ++round) {
        Field f = empty_box({8, 8, 8});
        for (int z = 1; z < 7; ++z)
            for (int y = 1; y < 7; ++y)
                for (int x = 1; x < 7; ++x) at(f, x, y, z) = values[draw.below(5)];
        EXPECT_EQ(fault(isosurface(f, 0.5f)), "");
    }
}

TEST(SurfaceTable, FieldThatIsNotEmptyAtItsBorderIsRefused)
{
    for (int corner = 0; corner < 8; ++corner) {
        Field f = empty_box({4, 5, 6});
        at(f, corner & 1 ? 3 : 0, corner & 2 ? 4 : 0, corner & 4 ? 5 : 0) = 1;
        EXPECT_THROW(isosurface(f, 0.5f), std::runtime_error);
    }
    Field f = empty_box({4, 5, 6});
    at(f, 3, 2, 2) = 1;
    EXPECT_THROW(isosurface(f, 0.5f), std::runtime_error);
    EXPECT_TRUE(isosurface(Field{}, 0.5f).triangles.empty());
}

TEST(SurfaceShape, BallHasEulerTwoAndItsAnalyticVolume)
{
    const double r = 0.31;
    const Mesh m = isosurface(field_of(49,
                                       [&](Vec3<double> x) {
                                           return length(x - Vec3<double>{0.5, 0.49, 0.51}) - r;
                                       }),
                              0.5f);
    EXPECT_EQ(fault(m), "");
    EXPECT_EQ(euler(m), 2);
    EXPECT_EQ(components(m), 1);
    EXPECT_NEAR(volume(m) / (4.0 / 3 * pi * r * r * r), 1, 0.01);
}

TEST(SurfaceShape, TorusHasEulerZeroAndItsAnalyticVolume)
{
    const double R = 0.28, r = 0.13;
    const Mesh m = isosurface(field_of(65,
                                       [&](Vec3<double> x) {
                                           const Vec3<double> d = x - Vec3<double>{0.5, 0.5, 0.5};
                                           return std::hypot(std::hypot(d.x, d.z) - R, d.y) - r;
                                       }),
                              0.5f);
    EXPECT_EQ(fault(m), "");
    EXPECT_EQ(euler(m), 0);
    EXPECT_EQ(components(m), 1);
    EXPECT_NEAR(volume(m) / (2 * pi * pi * R * r * r), 1, 0.01);
}

TEST(SurfaceShape, TwoTouchingBallsAreClosedHoweverTheyTouch)
{
    for (int round = 0; round < 30; ++round) {
        const double gap = (round - 15) * 0.005;
        const Mesh m = isosurface(
            field_of(33,
                     [&](Vec3<double> x) {
                         return std::min(length(x - Vec3<double>{0.28 - gap, 0.5, 0.5}) - 0.2,
                                         length(x - Vec3<double>{0.68, 0.51, 0.5}) - 0.2);
                     }),
            0.5f);
        EXPECT_EQ(fault(m), "") << "gap " << gap;
        EXPECT_EQ(euler(m), 2 * components(m));
    }
}

TEST(SurfaceShape, NormalsOfABallPointOutward)
{
    const Vec3<double> centre{0.5, 0.49, 0.51};
    Mesh m =
        isosurface(field_of(33, [&](Vec3<double> x) { return length(x - centre) - 0.3; }), 0.5f);
    smooth(m, Smoothing::taubin, 5);
    ASSERT_EQ(m.normals.size(), m.vertices.size());
    for (std::size_t v = 0; v < m.normals.size(); ++v) {
        const Vec3<double> d = cast<double>(m.vertices[v]) - centre;
        EXPECT_NEAR(length(m.normals[v]), 1, 1e-5);
        EXPECT_GT(dot(cast<double>(m.normals[v]), d) / length(d), 0.97);
    }
}

TEST(SurfaceShape, TaubinKeepsTheVolumeThatLaplaceLoses)
{
    const Field f = field_of(33, [](Vec3<double> x) {
        return length(x - Vec3<double>{0.5, 0.5, 0.5}) - 0.3;
    });
    const Mesh raw = isosurface(f, 0.5f);
    Mesh laplace = raw, taubin = raw, none = raw;
    smooth(laplace, Smoothing::laplace, 5);
    smooth(taubin, Smoothing::taubin, 5);
    smooth(none, Smoothing::none, 5);
    EXPECT_EQ(volume(none), volume(raw));
    EXPECT_NEAR(volume(taubin) / volume(raw), 1, 0.002);
    EXPECT_LT(volume(laplace) / volume(raw), 0.985);
}

TEST(SurfaceColour, FirstTwelveCategoriesLookDifferent)
{
    for (int a = 0; a < 12; ++a)
        for (int b = 0; b < a; ++b)
            EXPECT_GT(length(category_colour(a) - category_colour(b)), 0.1f) << a << ' ' << b;
    for (const int wild : {-1, 12, INT32_MIN, INT32_MAX}) {
        const Vec3<float> c = category_colour(wild);
        EXPECT_TRUE(c.x >= 0 && c.x <= 1 && c.y >= 0 && c.y <= 1 && c.z >= 0 && c.z <= 1);
    }
}

}  // namespace
}  // namespace knead
