// A splat's covariance and colour against closed forms: Eigen's rotations, harmonics from
// associated Legendre functions, integrals by a Gauss-Legendre rule.
#include "cuda/splats/gaussian.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/solver/samples.h"

namespace knead {
namespace {

using std::numbers::pi;
constexpr int all = harmonics(max_sh_degree);
using Values = std::array<double, all>;
template <class R>
using Coefficients = std::array<Vec3<R>, all>;

template <class R>
Values values(Vec3<R> d, int degree = max_sh_degree)
{
    Values y{};
    each_harmonic(degree, d, [&](int k, R value) { y[std::size_t(k)] = double(value); });
    return y;
}

double factorial(int n) { return std::tgamma(n + 1.0); }

// [Sloan 2008], appendix A1, times (-1)^m.
double by_legendre(int l, int m, Vec3<double> d)
{
    const int n = std::abs(m);
    const double norm = std::sqrt((2 * l + 1) / (4 * pi) * factorial(l - n) / factorial(l + n)) *
                        (m == 0 ? 1 : std::sqrt(2.0));
    const double azimuth = std::atan2(d.y, d.x);
    const double wave = m < 0 ? std::sin(n * azimuth) : std::cos(n * azimuth);
    return (n % 2 ? -1 : 1) * norm * std::assoc_legendre(unsigned(l), unsigned(n), d.z) * wave;
}

template <class R>
class Splat : public testing::Test {
};
TYPED_TEST_SUITE(Splat, Scalars);

TYPED_TEST(Splat, HarmonicsAreAssociatedLegendreFunctions)
{
    using R = TypeParam;
    Draw draw(1);
    for (int i = 0; i < 200; ++i) {
        const Vec3<R> d = cast<R>(draw.direction());
        const Values y = values(d);
        for (int l = 0; l <= max_sh_degree; ++l)
            for (int m = -l; m <= l; ++m)
                EXPECT_NEAR(y[std::size_t(l * (l + 1) + m)], by_legendre(l, m, cast<double>(d)),
                            either<R>(2e-6, 1e-13))
                    << l << ", " << m;
    }
}

// The signs that files are written with: -y, z, -x in degree 1.
TEST(Harmonics, TheFirstDegreePointsDownItsAxes)
{
    const double c = std::sqrt(3 / (4 * pi));
    EXPECT_NEAR(values(Vec3<double>{0, 1, 0})[1], -c, 1e-15);
    EXPECT_NEAR(values(Vec3<double>{0, 0, 1})[2], c, 1e-15);
    EXPECT_NEAR(values(Vec3<double>{1, 0, 0})[3], -c, 1e-15);
}

// Four Gauss-Legendre nodes along z and eight around: exact to degree 7, the products have 6.
template <class Use>
void each_gauss(Use&& use)
{
    for (double s : {-1.0, 1.0})
        for (double t : {-1.0, 1.0}) {
            const double z = t * std::sqrt(3.0 / 7 + s * 2.0 / 7 * std::sqrt(6.0 / 5));
            const double weight = (18 - s * std::sqrt(30.0)) / 36 * 2 * pi / 8;
            for (int k = 0; k < 8; ++k) {
                const double a = 2 * pi * (k + 0.3) / 8, r = std::sqrt(1 - z * z);
                use(Vec3<double>{r * std::cos(a), r * std::sin(a), z}, weight);
            }
        }
}

template <class Each>
double worst_product(Each&& each)
{
    std::array<Values, all> sum{};
    each([&](Vec3<double> d, double weight) {
        const Values y = values(d);
        for (std::size_t i = 0; i < all; ++i)
            for (std::size_t j = 0; j < all; ++j) sum[i][j] += weight * y[i] * y[j];
    });
    double worst = 0;
    for (std::size_t i = 0; i < all; ++i)
        for (std::size_t j = 0; j < all; ++j)
            worst = std::max(worst, std::abs(sum[i][j] - (i == j ? 1 : 0)));
    return worst;
}

TEST(Harmonics, AreOrthonormalByTwoRules)
{
    EXPECT_LT(worst_product([](auto&& use) { each_gauss(use); }), 1e-13);
    EXPECT_LT(worst_product([](auto&& use) { each_lebedev<double>(use); }), 1e-13);
}

TEST(Harmonics, ALowerDegreeIsTheBeginningOfAHigher)
{
    const Vec3<double> d = Draw(2).direction();
    const Values y = values(d);
    for (int degree = 0; degree <= max_sh_degree; ++degree) {
        int calls = 0;
        each_harmonic(degree, d, [&](int k, double v) { calls += v == y[std::size_t(k)]; });
        EXPECT_EQ(calls, harmonics(degree));
    }
}

TEST(Harmonics, AColourIsHalfPlusTheSumAndNeverNegative)
{
    const Coefficients<double> c{Vec3<double>{1, 0, -9}, Vec3<double>{0, 2, 0}};
    const Vec3<double> d{0, 1, 0};
    const auto at = [&](int k) { return c[std::size_t(k)]; };
    const Vec3<double> flat = sh_colour(0, d, at), turned = sh_colour(1, d, at);
    EXPECT_NEAR(flat.x, 0.5 + 1 / (2 * std::sqrt(pi)), 1e-15);
    EXPECT_EQ(flat.y, 0.5);
    EXPECT_EQ(flat.z, 0);
    EXPECT_EQ(turned.y, 0);  // 1/2 - 2 sqrt(3 / (4 pi)) is negative
    EXPECT_NEAR(sh_colour(1, Vec3<double>{0, -1, 0}, at).y, 0.5 + std::sqrt(3 / pi), 1e-15);
}

template <class R>
Coefficients<R> drawn(Draw& draw)
{
    Coefficients<R> c;
    for (Vec3<R>& v : c) v = cast<R>(draw.vector());
    return c;
}

template <class R>
Coefficients<R> turned(const Mat3<R>& Q, const Coefficients<R>& c, int degree = max_sh_degree)
{
    Coefficients<R> sum{};
    turn_harmonics(
        degree, Q, [&](int k) { return c[std::size_t(k)]; },
        [&](int k, Vec3<R> v) { sum[std::size_t(k)] = sum[std::size_t(k)] + v; });
    return sum;
}

template <class R>
double apart(const Coefficients<R>& a, const Coefficients<R>& b)
{
    double most = 0;
    for (std::size_t k = 0; k < all; ++k) most = std::max(most, double(length(a[k] - b[k])));
    return most;
}

TYPED_TEST(Splat, TurnedCoefficientsLookTheSameFromTheTurnedDirection)
{
    using R = TypeParam;
    Draw draw(3);
    for (int i = 0; i < 100; ++i) {
        const Coefficients<R> c = drawn<R>(draw);
        const Mat3<R> Q = cast<R>(draw.rotation());
        for (int degree = 0; degree <= max_sh_degree; ++degree) {
            const Coefficients<R> t = turned(Q, c, degree);
            const Vec3<R> d = cast<R>(draw.direction());
            Vec3<R> before{}, after{};
            each_harmonic(degree, d, [&](int k, R y) { before = before + y * c[std::size_t(k)]; });
            each_harmonic(degree, Q * d,
                          [&](int k, R y) { after = after + y * t[std::size_t(k)]; });
            EXPECT_LT(length(after - before), either<R>(1e-5, 1e-13));
        }
    }
}

TYPED_TEST(Splat, TurningCoefficientsKeepsEachDegreeAndFollowsTheRotations)
{
    using R = TypeParam;
    const double tolerance = either<R>(1e-5, 1e-13);
    Draw draw(4);
    for (int i = 0; i < 50; ++i) {
        const Coefficients<R> c = drawn<R>(draw);
        const Mat3<R> P = cast<R>(draw.rotation()), Q = cast<R>(draw.rotation());
        const Coefficients<R> t = turned(P, c);
        for (int l = 0; l <= max_sh_degree; ++l) {
            double before = 0, after = 0;
            for (int k = l * l; k < harmonics(l); ++k) {
                before += dot(c[std::size_t(k)], c[std::size_t(k)]);
                after += dot(t[std::size_t(k)], t[std::size_t(k)]);
            }
            EXPECT_NEAR(after, before, 4 * tolerance) << l;
        }
        EXPECT_LT(apart(turned(Q, t), turned(Q * P, c)), tolerance);
        EXPECT_LT(apart(turned(transpose(P), t), c), tolerance);
        EXPECT_LT(apart(turned(diagonal(R(1)), c), c), tolerance);
    }
}

// An oblate splat, say, has no preferred axes in its plane: what counts is the covariance.
TYPED_TEST(Splat, ACovarianceIsThatOfEigensRotationAndComesBackFromItsEllipsoid)
{
    using R = TypeParam;
    Draw draw(5);
    const double tolerance = either<R>(2e-6, 1e-14);
    for (int i = 0; i < 400; ++i) {
        const ::Eigen::Quaterniond q =
            ::Eigen::Quaterniond(draw.in(-1, 1), draw.in(-1, 1), draw.in(-1, 1), draw.in(-1, 1))
                .normalized();
        Vec3<double> s{draw.power(-5, 1), draw.power(-5, 1), draw.power(-5, 1)};
        if (i % 4 == 1) s.y = s.x;
        if (i % 4 == 2) s.x = s.y = s.z;
        if (i % 4 == 3) s.z = 0;
        const Ellipsoid<R> e{cast<R>(Quat<double>{q.w(), q.x(), q.y(), q.z()}), cast<R>(s)};
        const Sym3<R> sigma = covariance(e);
        const ::Eigen::Matrix3d rotated =
            q.toRotationMatrix() * ::Eigen::Vector3d(s.x * s.x, s.y * s.y, s.z * s.z).asDiagonal() *
            q.toRotationMatrix().transpose();
        const Sym3<double> expected{rotated(0, 0), rotated(1, 1), rotated(2, 2),
                                    rotated(0, 1), rotated(0, 2), rotated(1, 2)};
        const double scale = size(expected);
        EXPECT_LT(size(cast<double>(sigma) - expected), tolerance * scale);

        const Ellipsoid<R> back = ellipsoid(sigma);
        EXPECT_LT(size(cast<double>(covariance(back)) - expected), 5 * tolerance * scale);
        EXPECT_NEAR(double(determinant(rotation(back.q))), 1, 5 * tolerance);
        std::array<double, 3> drawn{s.x, s.y, s.z},
            found{double(back.scale.x), double(back.scale.y), double(back.scale.z)};
        std::sort(drawn.begin(), drawn.end());
        std::sort(found.begin(), found.end());
        // A half axis is the root of a value that rounding moves by its share of the largest.
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_NEAR(found[k] * found[k], drawn[k] * drawn[k], 5 * tolerance * scale);
    }
}

TEST(Rotations, QuaternionsAndMatricesAreTheSameTurn)
{
    Draw draw(6);
    for (int i = 0; i < 400; ++i) {
        Mat3<double> Q = draw.rotation();
        if (i < 3)  // half turns: the real part vanishes
            Q = {{i == 0 ? 1.0 : -1.0, 0, 0},
                 {0, i == 1 ? 1.0 : -1.0, 0},
                 {0, 0, i == 2 ? 1.0 : -1.0}};
        EXPECT_LT(size(rotation(quaternion(Q)) - Q), 1e-14);
    }
}

}  // namespace
}  // namespace knead
