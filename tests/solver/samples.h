// Random input for the tests: drawn in double, rounded to the scalar under test, the same on every
// run, so that an oracle in double sees exactly the numbers that the code under test saw.
#pragma once
#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "cuda/math/vec.h"

namespace knead {

using Scalars = ::testing::Types<float, double>;

// One of two numbers, by the scalar under test: mostly a tolerance.
template <class R>
constexpr double either(double in_float, double in_double)
{
    return sizeof(R) == 4 ? in_float : in_double;
}

template <class To, class R>
Sym3<To> cast(const Sym3<R>& A)
{
    return {To(A.xx), To(A.yy), To(A.zz), To(A.xy), To(A.xz), To(A.yz)};
}
template <class To, class R>
Mat3<To> cast(const Mat3<R>& A)
{
    return {cast<To>(A.a), cast<To>(A.b), cast<To>(A.c)};
}
template <class R>
Sym3<R> operator-(const Sym3<R>& A, const Sym3<R>& B)
{
    return A + R(-1) * B;
}
template <class R>
R size(const Sym3<R>& A)
{
    return std::sqrt(norm_squared(A));
}
template <class R>
R size(const Mat3<R>& A)
{
    return std::sqrt(dot(A.a, A.a) + dot(A.b, A.b) + dot(A.c, A.c));
}
template <class R>
bool same(const Sym3<R>& A, const Sym3<R>& B)  // to the bit
{
    return A.xx == B.xx && A.yy == B.yy && A.zz == B.zz && A.xy == B.xy && A.xz == B.xz &&
           A.yz == B.yz;
}
template <class R>
bool finite(const Sym3<R>& A)
{
    return std::isfinite(A.xx) && std::isfinite(A.yy) && std::isfinite(A.zz) &&
           std::isfinite(A.xy) && std::isfinite(A.xz) && std::isfinite(A.yz);
}

// A turned by the rotation Q.
template <class R>
Sym3<R> turned(const Mat3<R>& Q, const Sym3<R>& A)
{
    return symmetric(Q * full(A) * transpose(Q));
}

class Draw {
  public:
    explicit Draw(std::uint64_t seed) : engine_(seed) {}

    double in(double low, double high)
    {
        return low + (high - low) * double(engine_() >> 11) * 0x1p-53;
    }
    double power(double low, double high)  // 10 to an evenly drawn power
    {
        return std::pow(10.0, in(low, high));
    }
    int below(int n) { return int(engine_() % std::uint64_t(n)); }
    Vec3<double> vector(double reach = 1)
    {
        const double x = in(-reach, reach), y = in(-reach, reach);
        return {x, y, in(-reach, reach)};
    }
    Vec3<double> direction()
    {
        for (;;) {
            const Vec3<double> v = vector();
            const double n = length(v);
            if (n > 0.1 && n < 1) return (1 / n) * v;
        }
    }
    Mat3<double> matrix(double reach = 1)
    {
        const Vec3<double> a = vector(reach), b = vector(reach);
        return {a, b, vector(reach)};
    }
    Mat3<double> rotation()
    {
        const Vec3<double> a = direction(), n = orthogonal(a), m = cross(a, n);
        const double angle = in(0, 6.283185307179586);
        const Vec3<double> b = std::cos(angle) * n + std::sin(angle) * m;
        return {a, b, cross(a, b)};
    }
    // b - I of a deformation I + (up to reach) in every element; never inverted for reach < 1/3.
    Sym3<double> strain(double reach)
    {
        const Mat3<double> H = matrix(reach);
        return symmetric(H + transpose(H) + H * transpose(H));
    }

  private:
    std::mt19937_64 engine_;
};

}  // namespace knead
