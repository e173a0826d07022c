// Distances to balls, cones and slabs against a brute-force minimum over the simplex of the
// spheres, over every way in which a primitive may degenerate, and the properties an exact distance
// has.
#include "cuda/contact/medial.h"

#include <algorithm>
#include <array>

#include "cuda/math/box.h"
#include "tests/contact/medial_cases.h"

namespace knead {
namespace {

template <class R>
class MedialTest : public ::testing::Test {
};
TYPED_TEST_SUITE(MedialTest, Scalars);

TYPED_TEST(MedialTest, SlabDistanceAgreesWithBruteForceInEveryDegenerateFamily)
{
    using R = TypeParam;
    for (const Family& f : families()) {
        Draw draw(11);
        double worst = 0;
        for (int round = 0; round < 250; ++round) {
            const Case k = f.draw(draw), seen = rounded<R>(k);
            const ClosestPoint<R> found = closest_point(shape_of<R>(k), cast<R>(k.p));
            worst = std::max(worst, std::abs(double(found.phi) - brute(seen, 3)));
        }
        EXPECT_LT(worst, either<R>(1e-5, 1e-12)) << f.name;
    }
}

TYPED_TEST(MedialTest, ConeDistanceAgreesWithBruteForce)
{
    using R = TypeParam;
    Draw draw(12);
    double worst = 0;
    for (int round = 0; round < 20000; ++round) {
        Case k = round % 2 ? generic(draw) : near_nested(draw);
        if (round % 10 == 0) k.c[1] = k.c[0];
        if (round % 7 == 0) k.r[1] = k.r[0] + (1 - draw.power(-13, 0)) * length(k.c[1] - k.c[0]);
        if (round % 11 == 0) k.p = k.c[0] + draw.in(-1, 2) * (k.c[1] - k.c[0]);
        const ClosestPoint<R> found = closest_point(shape_of<R>(k, 2), cast<R>(k.p));
        worst = std::max(worst, std::abs(double(found.phi) - brute(rounded<R>(k), 2)));
        EXPECT_EQ(found.l2, 0);
    }
    EXPECT_LT(worst, either<R>(2e-6, 1e-12));
}

TYPED_TEST(MedialTest, BallDistanceIsExactAndItsCentreHasANormal)
{
    using R = TypeParam;
    Draw draw(13);
    for (int round = 0; round < 1000; ++round) {
        const Case k = rounded<R>(generic(draw));
        const Shape<R> ball = shape_of<R>(k, 1);
        EXPECT_NEAR(double(closest_point(ball, cast<R>(k.p)).phi), length(k.p - k.c[0]) - k.r[0],
                    either<R>(1e-6, 1e-15));
        const ClosestPoint<R> centre = closest_point(ball, cast<R>(k.c[0]));
        EXPECT_EQ(centre.phi, -R(k.r[0]));
        EXPECT_NEAR(double(length(centre.n)), 1, 1e-6);
    }
}

TYPED_TEST(MedialTest, WeightsSumToOneAndPlaceTheFootAtTheDistance)
{
    using R = TypeParam;
    for (const Family& f : families()) {
        Draw draw(14);
        for (int round = 0; round < 400; ++round) {
            const Case k = f.draw(draw), seen = rounded<R>(k);
            const ClosestPoint<R> found = closest_point(shape_of<R>(k), cast<R>(k.p));
            EXPECT_NEAR(double(found.l0) + found.l1 + found.l2, 1, either<R>(1e-6, 1e-14))
                << f.name;
            EXPECT_GE(std::min({found.l0, found.l1, found.l2}), R(-either<R>(1e-6, 1e-14)))
                << f.name;
            // Across a sliver the weights are worth fewer digits than the distance.
            const double tolerance =
                f.name == "sliver" ? either<R>(1e-3, 1e-7) : either<R>(1e-5, 1e-12);
            EXPECT_NEAR(at(seen, found.l1, found.l2), double(found.phi), tolerance) << f.name;
        }
    }
}

TYPED_TEST(MedialTest, TheNormalIsUnitAndLeadsToTheSurface)
{
    using R = TypeParam;
    for (const Family& f : families()) {
        Draw draw(15);
        double worst = 0;
        for (int round = 0; round < 1000; ++round) {
            const Case k = f.draw(draw);
            const Shape<R> s = shape_of<R>(k);
            const Vec3<R> p = cast<R>(k.p);
            const ClosestPoint<R> found = closest_point(s, p);
            EXPECT_NEAR(double(length(found.n)), 1, either<R>(3e-6, 1e-12)) << f.name;
            if (above_sheet(k, found) < either<R>(0.01, 1e-5)) continue;
            worst =
                std::max(worst, std::abs(double(closest_point(s, p - found.phi * found.n).phi)));
        }
        EXPECT_LT(worst, either<R>(2e-5, 1e-11)) << f.name;
    }
}

TYPED_TEST(MedialTest, OnTheAxisOfAConeTheNormalLeadsToItsSurfaceToo)
{
    using R = TypeParam;
    Draw draw(24);
    for (int round = 0; round < 2000; ++round) {
        Case k = generic(draw);  // along x, so that rounding keeps the point on the axis
        k.c[0] = {0, 0, 0}, k.c[1] = {draw.in(0.6, 1), 0, 0};
        k.p = draw.in(-0.3, 1.3) * k.c[1];
        const Shape<R> s = shape_of<R>(k, 2);
        const ClosestPoint<R> found = closest_point(s, cast<R>(k.p));
        EXPECT_NEAR(double(length(found.n)), 1, either<R>(1e-6, 1e-15));
        EXPECT_NEAR(double(closest_point(s, cast<R>(k.p) - found.phi * found.n).phi), 0,
                    either<R>(1e-6, 1e-15));
    }
}

TYPED_TEST(MedialTest, TheNormalIsTheGradientByFiniteDifferences)
{
    using R = TypeParam;
    const double h = 1e-6;
    for (const Family& f : families()) {
        Draw draw(16);
        double worst = 0;
        for (int round = 0; round < 1000; ++round) {
            const Case k = rounded<R>(f.draw(draw));
            const Shape<double> s = shape_of<double>(k);
            const ClosestPoint<R> found = closest_point(shape_of<R>(k), cast<R>(k.p));
            const auto slope = [&](Vec3<double> e) {
                return (closest_point(s, k.p + h * e).phi - closest_point(s, k.p - h * e).phi) /
                       (2 * h);
            };
            const Vec3<double> gradient{slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})};
            if (above_sheet(k, found) < 0.02) continue;
            worst = std::max(worst, length(gradient - cast<double>(found.n)));
        }
        EXPECT_LT(worst, either<R>(2e-3, 3e-4)) << f.name;
    }
}

TYPED_TEST(MedialTest, TheOrderOfTheSpheresDoesNotMatter)
{
    using R = TypeParam;
    const std::array<int, 3> input[] = {{0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (const Family& f : families()) {
        Draw draw(17);
        for (int round = 0; round < 300; ++round) {
            const Case k = f.draw(draw);
            const ClosestPoint<R> expected = closest_point(shape_of<R>(k), cast<R>(k.p));
            for (const std::array<int, 3>& order : input)
                EXPECT_NEAR(double(closest_point(shape_of<R>(k, 3, order), cast<R>(k.p)).phi),
                            double(expected.phi), either<R>(1e-5, 1e-12))
                    << f.name;
        }
    }
}

TYPED_TEST(MedialTest, ASlabIsNowhereFartherThanItsEdgesNorAConeThanItsBalls)
{
    using R = TypeParam;
    for (const Family& f : families()) {
        Draw draw(18);
        for (int round = 0; round < 500; ++round) {
            const Case k = f.draw(draw);
            const R phi = closest_point(shape_of<R>(k), cast<R>(k.p)).phi,
                    slack = R(either<R>(1e-5, 1e-12));
            for (const std::array<int, 3>& order : {std::array{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}) {
                const R edge = closest_point(shape_of<R>(k, 2, order), cast<R>(k.p)).phi;
                EXPECT_LE(phi, edge + slack) << f.name;
                EXPECT_LE(edge, closest_point(shape_of<R>(k, 1, order), cast<R>(k.p)).phi + slack)
                    << f.name;
            }
        }
    }
}

TYPED_TEST(MedialTest, ASlabWithTwoEqualSpheresIsTheCone)
{
    using R = TypeParam;
    Draw draw(19);
    for (int round = 0; round < 2000; ++round) {
        Case k = generic(draw);
        k.c[2] = k.c[1], k.r[2] = k.r[1];
        const ClosestPoint<R> slab = closest_point(shape_of<R>(k), cast<R>(k.p)),
                              cone = closest_point(shape_of<R>(k, 2), cast<R>(k.p));
        EXPECT_NEAR(double(slab.phi), double(cone.phi), either<R>(1e-6, 1e-15));
        EXPECT_LT(length(slab.n - cone.n), either<R>(1e-4, 1e-12));
    }
}

TYPED_TEST(MedialTest, TheDistanceNeverChangesFasterThanThePointMoves)
{
    using R = TypeParam;
    for (const Family& f : families()) {
        Draw draw(20);
        for (int round = 0; round < 1000; ++round) {
            const Case k = f.draw(draw);
            const Shape<R> s = shape_of<R>(k);
            const Vec3<R> p = cast<R>(k.p), q = p + cast<R>(draw.power(-7, 0) * draw.direction());
            EXPECT_LE(std::abs(double(closest_point(s, p).phi) - double(closest_point(s, q).phi)),
                      double(length(p - q)) + either<R>(1e-5, 1e-12))
                << f.name;
        }
    }
}

TYPED_TEST(MedialTest, DistanceAndNormalAreContinuousAcrossTheBordersOfASlab)
{
    using R = TypeParam;
    Draw draw(21);
    int crossed = 0;
    for (int round = 0; round < 2000; ++round) {
        const Case k = generic(draw);
        const Shape<R> s = shape_of<R>(k);
        const Vec3<R> a = cast<R>(k.p), b = cast<R>(draw.vector(1.5));
        const auto inner = [](const ClosestPoint<R>& f) {
            return f.l0 > 0 && f.l1 > 0 && f.l2 > 0;
        };
        const auto on_line = [&](double t) { return closest_point(s, a + R(t) * (b - a)); };
        if (inner(on_line(0)) == inner(on_line(1))) continue;
        double low = 0, high = 1;
        const int halvings = sizeof(R) == 4 ? 18 : 40;
        for (int i = 0; i < halvings; ++i) {
            const double t = (low + high) / 2;
            (inner(on_line(t)) == inner(on_line(0)) ? low : high) = t;
        }
        const ClosestPoint<R> before = on_line(low), after = on_line(high);
        if (above_sheet(k, before) < 0.05) continue;
        ++crossed;
        EXPECT_NEAR(double(before.phi), double(after.phi), either<R>(2e-5, 1e-11));
        EXPECT_LT(length(before.n - after.n), either<R>(2e-3, 1e-5));
    }
    EXPECT_GT(crossed, 150);
}

TYPED_TEST(MedialTest, TheBoxHoldsTheShapeTightly)
{
    using R = TypeParam;
    Draw draw(22);
    for (int round = 0; round < 500; ++round) {
        const Case k = generic(draw);
        const Shape<R> s = shape_of<R>(k);
        for (int i = 0; i < 3; ++i)
            for (const Vec3<double>& e : {Vec3<double>{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}) {
                const std::size_t n = std::size_t(i);
                EXPECT_GE(dot(cast<double>(s.high), e), dot(k.c[n], e) + k.r[n] - 1e-6);
                EXPECT_LE(dot(cast<double>(s.low), e), dot(k.c[n], e) - k.r[n] + 1e-6);
            }
        const auto top = [&](auto pick) {
            return std::max({pick(k.c[0]) + k.r[0], pick(k.c[1]) + k.r[1], pick(k.c[2]) + k.r[2]});
        };
        EXPECT_NEAR(double(s.high.x), top([](Vec3<double> c) { return c.x; }), 1e-6);
        EXPECT_NEAR(double(s.high.z), top([](Vec3<double> c) { return c.z; }), 1e-6);
        EXPECT_NEAR(double(s.low.y), -top([](Vec3<double> c) { return -c.y; }), 1e-6);
    }
}

TYPED_TEST(MedialTest, EveryPointInsideIsEnclosedAndFewOthersAre)
{
    using R = TypeParam;
    const R rounding = R(either<R>(1e-6, 1e-14));  // of distances as large as the shape
    for (const Family& f : families()) {
        Draw draw(24);
        for (int round = 0; round < 500; ++round) {
            const Case k = f.draw(draw);
            for (int count = 1; count <= 3; ++count) {
                const Shape<R> s = shape_of<R>(k, count);
                for (int i = 0; i < 20; ++i) {
                    // Beside the surface, where rounding decides, and anywhere around.
                    const Vec3<R> p = cast<R>(k.p + draw.power(-7, 0) * draw.direction());
                    const ClosestPoint<R> near = closest_point(s, p);
                    const Vec3<R> under = p - (near.phi + R(draw.power(-6, -1))) * near.n;
                    for (const Vec3<R>& x : {p, under}) {
                        if (enclosed(s, x)) continue;
                        EXPECT_GE(closest_point(s, x).phi, -rounding) << f.name << count;
                    }
                }
            }
        }
    }
    Draw draw(25);
    int boxed = 0, left = 0, inside = 0;
    for (int round = 0; round < 20000; ++round) {
        const Case k = generic(draw);
        const Shape<R> s = shape_of<R>(k, 2 + round % 2);
        const Vec3<R> p = cast<R>(k.p);
        boxed += contains({s.low, s.high}, p);
        left += enclosed(s, p), inside += closest_point(s, p).phi < 0;
    }
    EXPECT_GT(inside, 100);
    EXPECT_LT(left - inside, 0.75 * (boxed - inside));
}

TYPED_TEST(MedialTest, DistancesScaleWithTheShapeDownToMicrometres)
{
    using R = TypeParam;
    Draw draw(23);
    for (int round = 0; round < 1000; ++round) {
        Case k = generic(draw);
        const double phi = closest_point(shape_of<double>(k), k.p).phi, scale = draw.power(-6, 3);
        for (Vec3<double>& c : k.c) c = scale * c;
        for (double& r : k.r) r *= scale;
        EXPECT_NEAR(double(closest_point(shape_of<R>(k), cast<R>(scale * k.p)).phi), scale * phi,
                    scale * either<R>(1e-5, 1e-12));
    }
}

}  // namespace
}  // namespace knead
