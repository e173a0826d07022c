// Distances to balls, cones and slabs against a brute-force minimum over the simplex of the
// spheres, over every way in which a primitive may degenerate, and the properties an exact distance
// has.
#include "cuda/medial.h"

#include <algorithm>
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "samples.h"

namespace knead {
namespace {

template <class R>
class MedialTest : public ::testing::Test {
};
TYPED_TEST_SUITE(MedialTest, Scalars);

// Three spheres and a point near them.
struct Case {
    std::array<Vec3<double>, 3> c;
    std::array<double, 3> r;
    Vec3<double> p;
};

template <class R>
Shape<R> shape_of(const Case& k, int count = 3, std::array<int, 3> order = {0, 1, 2})
{
    Sphere<R> s[3]{};
    for (int i = 0; i < 3; ++i) {
        const std::size_t from = std::size_t(order[std::size_t(std::min(i, count - 1))]);
        s[i].c = cast<R>(k.c[from]);
        s[i].r = R(k.r[from]);
    }
    return shape(count, s[0], s[1], s[2]);
}

// The case that code in the scalar R sees.
template <class R>
Case rounded(Case k)
{
    for (Vec3<double>& c : k.c) c = cast<double>(cast<R>(c));
    for (double& r : k.r) r = R(r);
    k.p = cast<double>(cast<R>(k.p));
    return k;
}

double at(const Case& k, double l1, double l2)
{
    const double l0 = 1 - l1 - l2;
    return length(k.p - (l0 * k.c[0] + l1 * k.c[1] + l2 * k.c[2])) -
           (l0 * k.r[0] + l1 * k.r[1] + l2 * k.r[2]);
}

// Least value of a convex function on [0, 1] by golden section.
template <class F>
double least_of(F&& f)
{
    constexpr double ratio = 0.6180339887498949;
    double low = 0, high = 1, x = 1 - ratio, y = ratio, fx = f(x), fy = f(y);
    for (int i = 0; i < 80; ++i) {
        if (fx < fy) {
            high = y, y = x, fy = fx, x = high - ratio * (high - low), fx = f(x);
        } else {
            low = x, x = y, fx = fy, y = low + ratio * (high - low), fy = f(y);
        }
    }
    return std::min(fx, fy);
}

double brute(const Case& k, int count)
{
    double best = at(k, 0, 0);
    if (count > 1)
        best = std::min({best, at(k, 1, 0), least_of([&](double t) { return at(k, t, 0); })});
    if (count < 3) return best;
    best = std::min(best, at(k, 0, 1));
    return std::min(best, least_of([&](double u) {
                        return least_of([&](double w) { return at(k, u * (1 - w), u * w); });
                    }));
}

// How far the point is from the sheet of the centres: there the distance has a crease, and the
// normal jumps from one side to the other.
template <class R>
double above_sheet(const Case& k, const Foot<R>& f)
{
    return double(f.phi) + double(f.l0) * k.r[0] + double(f.l1) * k.r[1] + double(f.l2) * k.r[2];
}

struct Family {
    std::string name;
    std::function<Case(Draw&)> draw;
};

Case generic(Draw& d)
{
    Case k;
    for (Vec3<double>& c : k.c) c = d.vector();
    for (double& r : k.r) r = d.in(0.1, 0.5);
    k.p = d.vector(1.5);
    return k;
}

// Radii that change by the gradient g, so that the spheres have common tangent planes for |g| < 1.
void taper(Case& k, Vec3<double> g)
{
    for (std::size_t i = 0; i < 3; ++i) k.r[i] = 1.5 + dot(g, k.c[i] - k.c[0]);
    const double least_radius = std::min({k.r[0], k.r[1], k.r[2]});
    for (double& r : k.r) r += 0.05 - least_radius;
}

Vec3<double> on_sheet(const Case& k, Draw& d)
{
    const double a = d.in(0, 1), b = d.in(0, 1 - a);
    return (1 - a - b) * k.c[0] + a * k.c[1] + b * k.c[2];
}

Case sliver(Draw& d)
{
    Case k = generic(d);
    const Vec3<double> u = d.direction();
    const double reach = d.in(0.3, 1), along = d.in(-0.5, 1.5) * reach;
    k.c[1] = k.c[0] + reach * u;
    k.c[2] = k.c[0] + along * u + (reach * d.power(-12, 0)) * orthogonal(u);
    taper(k, d.in(0, 0.95) * d.direction());
    if (d.below(2)) std::swap(k.c[0], k.c[2]), std::swap(k.r[0], k.r[2]);
    k.p = on_sheet(k, d) + d.power(-6, 0) * d.direction();
    return k;
}

Case collinear(Draw& d)
{
    Case k = generic(d);
    k.c[2] = k.c[0] + d.in(-1, 2) * (k.c[1] - k.c[0]);
    return k;
}

Case near_nested(Draw& d)  // the slope of the radius is 1 to between 1e-1 and 1e-13
{
    Case k = generic(d);
    const Vec3<double> N = cross(k.c[1] - k.c[0], k.c[2] - k.c[0]);
    const double area = length(N), angle = d.in(0, 6.3);
    if (area < 0.2) return near_nested(d);
    const Vec3<double> n = (1 / area) * N, t = orthogonal(n);
    const double slope = 1 + (d.below(2) ? -1 : 1) * d.power(-13, -1);
    taper(k, slope * (std::cos(angle) * t + std::sin(angle) * cross(n, t)));
    return k;
}

std::vector<Family> families()
{
    const auto with = [](auto change) {
        return [change](Draw& d) {
            Case k = generic(d);
            change(k, d);
            return k;
        };
    };
    return {
        {"generic", generic},
        {"strongly tapered or nested", with([](Case& k, Draw& d) {
             for (double& r : k.r) r = d.in(0.01, 1.5);
         })},
        {"sliver", sliver},
        {"collinear", collinear},
        {"two centres coincide", with([](Case& k, Draw& d) {
             k.c[std::size_t(d.below(2) + 1)] = k.c[0];
             if (d.below(2)) std::swap(k.c[0], k.c[2]), std::swap(k.r[0], k.r[2]);
         })},
        {"all centres coincide", with([](Case& k, Draw&) { k.c[1] = k.c[2] = k.c[0]; })},
        {"one ball contains all", with([](Case& k, Draw& d) {
             k.r[std::size_t(d.below(3))] = 4;
             k.p = d.vector(5);
         })},
        {"tiny radii", with([](Case& k, Draw& d) {
             for (double& r : k.r) r = d.in(0, 1e-3);
         })},
        {"sharp tips", with([](Case& k, Draw& d) { k.r[std::size_t(d.below(3))] = 0; })},
        {"on the sheet", with([](Case& k, Draw& d) { k.p = on_sheet(k, d); })},
        {"at a centre", with([](Case& k, Draw& d) { k.p = k.c[std::size_t(d.below(3))]; })},
        {"hardly a tangent plane", near_nested},
    };
}

TYPED_TEST(MedialTest, SlabDistanceAgreesWithBruteForceInEveryDegenerateFamily)
{
    using R = TypeParam;
    for (const Family& f : families()) {
        Draw draw(11);
        double worst = 0;
        for (int round = 0; round < 250; ++round) {
            const Case k = f.draw(draw), seen = rounded<R>(k);
            const Foot<R> found = foot(shape_of<R>(k), cast<R>(k.p));
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
        const Foot<R> found = foot(shape_of<R>(k, 2), cast<R>(k.p));
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
        EXPECT_NEAR(double(foot(ball, cast<R>(k.p)).phi), length(k.p - k.c[0]) - k.r[0],
                    either<R>(1e-6, 1e-15));
        const Foot<R> centre = foot(ball, cast<R>(k.c[0]));
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
            const Foot<R> found = foot(shape_of<R>(k), cast<R>(k.p));
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
            const Foot<R> found = foot(s, p);
            EXPECT_NEAR(double(length(found.n)), 1, either<R>(3e-6, 1e-12)) << f.name;
            if (above_sheet(k, found) < either<R>(0.01, 1e-5)) continue;
            worst = std::max(worst, std::abs(double(foot(s, p - found.phi * found.n).phi)));
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
        const Foot<R> found = foot(s, cast<R>(k.p));
        EXPECT_NEAR(double(length(found.n)), 1, either<R>(1e-6, 1e-15));
        EXPECT_NEAR(double(foot(s, cast<R>(k.p) - found.phi * found.n).phi), 0,
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
            const Foot<R> found = foot(shape_of<R>(k), cast<R>(k.p));
            const auto slope = [&](Vec3<double> e) {
                return (foot(s, k.p + h * e).phi - foot(s, k.p - h * e).phi) / (2 * h);
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
    const std::array<int, 3> orders[] = {{0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (const Family& f : families()) {
        Draw draw(17);
        for (int round = 0; round < 300; ++round) {
            const Case k = f.draw(draw);
            const Foot<R> expected = foot(shape_of<R>(k), cast<R>(k.p));
            for (const std::array<int, 3>& order : orders)
                EXPECT_NEAR(double(foot(shape_of<R>(k, 3, order), cast<R>(k.p)).phi),
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
            const R phi = foot(shape_of<R>(k), cast<R>(k.p)).phi, slack = R(either<R>(1e-5, 1e-12));
            for (const std::array<int, 3>& order : {std::array{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}) {
                const R edge = foot(shape_of<R>(k, 2, order), cast<R>(k.p)).phi;
                EXPECT_LE(phi, edge + slack) << f.name;
                EXPECT_LE(edge, foot(shape_of<R>(k, 1, order), cast<R>(k.p)).phi + slack) << f.name;
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
        const Foot<R> slab = foot(shape_of<R>(k), cast<R>(k.p)),
                      cone = foot(shape_of<R>(k, 2), cast<R>(k.p));
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
            EXPECT_LE(std::abs(double(foot(s, p).phi) - double(foot(s, q).phi)),
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
        const auto inner = [](const Foot<R>& f) { return f.l0 > 0 && f.l1 > 0 && f.l2 > 0; };
        const auto on_line = [&](double t) { return foot(s, a + R(t) * (b - a)); };
        if (inner(on_line(0)) == inner(on_line(1))) continue;
        double low = 0, high = 1;
        const int halvings = sizeof(R) == 4 ? 18 : 40;
        for (int i = 0; i < halvings; ++i) {
            const double t = (low + high) / 2;
            (inner(on_line(t)) == inner(on_line(0)) ? low : high) = t;
        }
        const Foot<R> before = on_line(low), after = on_line(high);
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

TYPED_TEST(MedialTest, DistancesScaleWithTheShapeDownToMicrometres)
{
    using R = TypeParam;
    Draw draw(23);
    for (int round = 0; round < 1000; ++round) {
        Case k = generic(draw);
        const double phi = foot(shape_of<double>(k), k.p).phi, scale = draw.power(-6, 3);
        for (Vec3<double>& c : k.c) c = scale * c;
        for (double& r : k.r) r *= scale;
        EXPECT_NEAR(double(foot(shape_of<R>(k), cast<R>(scale * k.p)).phi), scale * phi,
                    scale * either<R>(1e-5, 1e-12));
    }
}

}  // namespace
}  // namespace knead
