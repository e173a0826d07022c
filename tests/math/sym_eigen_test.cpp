// Symmetric eigenvalues and axes: backward error and orthonormality on everything that breaks such
// routines (repeated values, any rank, scales far apart, already diagonal, denormal), against
// Eigen.
#include "cuda/math/sym_eigen.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>

#include "tests/solver/samples.h"

namespace knead {
namespace {

template <class R>
class EigenTest : public ::testing::Test {
};
TYPED_TEST_SUITE(EigenTest, Scalars);

// Backward error and orthonormality, relative to the size of A.
template <class R>
void expect_sound(const Sym3<R>& A)
{
    const knead::Eigen<R> e = eigen(A);
    const Mat3<double> Q = cast<double>(e.axes);
    const Sym3<double> exact = cast<double>(A);
    const double scale = size(exact), tolerance = either<R>(1e-5, 2e-14);
    ASSERT_TRUE(std::isfinite(e.value.x) && std::isfinite(e.value.y) && std::isfinite(e.value.z));
    EXPECT_LE(size(transpose(Q) * Q - diagonal(1.0)), either<R>(3e-6, 5e-15));
    EXPECT_LE(size(composed(Q, cast<double>(e.value)) - exact),
              tolerance * scale + 8 * double(std::numeric_limits<R>::denorm_min()))
        << A.xx << ' ' << A.yy << ' ' << A.zz << ' ' << A.xy << ' ' << A.xz << ' ' << A.yz;
    EXPECT_LE(size(composed(e.axes, e.value) - A),
              R(tolerance * scale) + std::numeric_limits<R>::min());
}

std::array<double, 3> sorted(Vec3<double> v)
{
    std::array<double, 3> a{v.x, v.y, v.z};
    std::sort(a.begin(), a.end());
    return a;
}

TYPED_TEST(EigenTest, ValuesAgreeWithEigen)
{
    using R = TypeParam;
    Draw draw(1);
    for (int round = 0; round < 5000; ++round) {
        const Sym3<R> A = cast<R>(draw.power(-6, 6) * symmetric(draw.matrix()));
        const Mat3<double> F = full(cast<double>(A));
        ::Eigen::Matrix3d M;
        M << F.a.x, F.b.x, F.c.x, F.a.y, F.b.y, F.c.y, F.a.z, F.b.z, F.c.z;
        const ::Eigen::Vector3d expected =
            ::Eigen::SelfAdjointEigenSolver<::Eigen::Matrix3d>(M).eigenvalues();
        const std::array<double, 3> found = sorted(cast<double>(eigen(A).value));
        for (int k = 0; k < 3; ++k)
            EXPECT_NEAR(found[std::size_t(k)], expected[k], either<R>(3e-6, 5e-15) * M.norm());
        expect_sound(A);
    }
}

TYPED_TEST(EigenTest, EveryRankAndEveryRepetitionDecomposes)
{
    using R = TypeParam;
    Draw draw(2);
    const Vec3<double> spectra[] = {{0, 0, 0},        {1, 0, 0},         {1, 1, 0},    {1, 1, 1},
                                    {2, 1, 1},        {2, 2, 1},         {-1, 0, 1},   {-1, -1, 1},
                                    {1, 1 + 1e-7, 1}, {1, 1 + 1e-14, 2}, {1, 0, -0.5}, {1, 1e-7, 0},
                                    {1, 1e-3, 1e-6},  {-1, -1, -1}};
    for (const Vec3<double>& values : spectra)
        for (int round = 0; round < 300; ++round) {
            const double scale = round % 3 == 0 ? 1e6 : round % 3 == 1 ? 1e-6 : 1;
            const Mat3<double> Q = round % 7 ? draw.rotation() : diagonal(1.0);
            expect_sound(cast<R>(composed(Q, scale * values)));
        }
}

TYPED_TEST(EigenTest, ScalesFarApartStayFiniteAndSound)
{
    using R = TypeParam;
    Draw draw(3);
    for (int round = 0; round < 5000; ++round) {
        const double sign[] = {-1, 0, 1, 1};
        const Vec3<double> values{draw.power(-6, 6), sign[draw.below(4)] * draw.power(-6, 6),
                                  sign[draw.below(4)] * draw.power(-6, 6)};
        expect_sound(cast<R>(composed(draw.rotation(), values)));
    }
}

TYPED_TEST(EigenTest, EntriesOfAnyMagnitudeDenormalsIncludedNeverGiveANan)
{
    using R = TypeParam;
    Draw draw(4);
    const int low = sizeof(R) == 4 ? -44 : -320, high = sizeof(R) == 4 ? 17 : 150;
    for (int round = 0; round < 20000; ++round) {
        const auto entry = [&] {
            return draw.below(4) ? R((draw.below(2) ? 1 : -1) * draw.power(low, high)) : R(0);
        };
        const Sym3<R> A{entry(), entry(), entry(), entry(), entry(), entry()};
        const knead::Eigen<R> e = eigen(A);
        const Mat3<double> Q = cast<double>(e.axes);
        ASSERT_TRUE(finite(composed(e.axes, e.value)));
        ASSERT_LE(size(transpose(Q) * Q - diagonal(1.0)), either<R>(3e-6, 5e-15));
    }
}

TYPED_TEST(EigenTest, SmallStrainsKeepTheirRelativeDigits)
{
    using R = TypeParam;
    Draw draw(5);
    for (int round = 0; round < 2000; ++round) expect_sound(cast<R>(draw.strain(1e-7)));
}

TYPED_TEST(EigenTest, ADiagonalMatrixComesBackUntouched)
{
    using R = TypeParam;
    const knead::Eigen<R> e = eigen(Sym3<R>{3, -1, R(1e-6), 0, 0, 0});
    EXPECT_EQ(e.value.x, R(3));
    EXPECT_EQ(e.value.y, R(-1));
    EXPECT_EQ(e.value.z, R(1e-6));
    EXPECT_EQ(size(e.axes - diagonal(R(1))), 0);
}

}  // namespace
}  // namespace knead
