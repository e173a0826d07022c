// One splat of a photographed object: a 3D Gaussian whose covariance is given by its rotation and
// scales, and a view-dependent colour.  [Kerbl 2023]
#pragma once
#include "cuda/math/rotation.h"
#include "cuda/math/sym_eigen.h"

namespace knead {

// The ellipsoid of one standard deviation: its axes lie along the columns of rotation(q).
template <class R>
struct Ellipsoid {
    Quat<R> q;        // unit
    Vec3<R> scale{};  // half axes [m], at least 0
};

// Sigma = Q diag(s)^2 Q^T [m^2].  [Kerbl 2023]
template <class R>
HD Sym3<R> covariance(const Ellipsoid<R>& e)
{
    const Vec3<R> s = e.scale;
    return composed(rotation(e.q), Vec3<R>{s.x * s.x, s.y * s.y, s.z * s.z});
}

// The inverse, for a covariance changed by deformation: half axes in any order, and a rotation,
// never a reflection. Eigenvalues made negative by rounding give half axes of 0.
template <class R>
HD Ellipsoid<R> ellipsoid(const Sym3<R>& sigma)
{
    Eigen<R> e = eigen(sigma);
    if (determinant(e.axes) < 0) e.axes.c = -e.axes.c;
    const auto half_axis = [](R square) { return std::sqrt(max(square, R(0))); };
    return {quaternion(e.axes), {half_axis(e.value.x), half_axis(e.value.y), half_axis(e.value.z)}};
}

// Real spherical harmonics up to this degree.
constexpr int harmonics(int degree) { return (degree + 1) * (degree + 1); }
constexpr int max_sh_degree = 3;

// Y_0 = 1 / (2 sqrt(pi)): the contribution of a coefficient of degree 0 to a colour.
constexpr double sh_constant = 0.28209479177387814;

// Calls use(k, Y_k(d)) for all harmonics up to `degree`, at most 3, k = l (l + 1) + m, in the unit
// direction d. Orthonormal over the sphere; the sign is (-1)^m times that of computer graphics
// [Sloan 2008], as in the files of [Kerbl 2023].
template <class R, class Use>
HD void each_harmonic(int degree, Vec3<R> d, Use&& use)
{
    use(0, R(sh_constant));
    if (degree < 1) return;
    const R x = d.x, y = d.y, z = d.z;
    constexpr R c1 = R(0.4886025119029199);  // sqrt(3 / (4 pi))
    use(1, -c1 * y);
    use(2, c1 * z);
    use(3, -c1 * x);
    if (degree < 2) return;
    const R xx = x * x, yy = y * y, zz = z * z;
    constexpr R c2 = R(1.0925484305920792);  // sqrt(15 / (4 pi))
    use(4, c2 * x * y);
    use(5, -c2 * y * z);
    use(6, R(0.31539156525252005) * (2 * zz - xx - yy));  // sqrt(5 / (16 pi))
    use(7, -c2 * x * z);
    use(8, c2 / 2 * (xx - yy));
    if (degree < 3) return;
    constexpr R c33 = R(0.5900435899266435);  // sqrt(35 / (32 pi))
    constexpr R c32 = R(2.890611442640554);   // sqrt(105 / (4 pi))
    constexpr R c31 = R(0.4570457994644658);  // sqrt(21 / (32 pi))
    use(9, -c33 * y * (3 * xx - yy));
    use(10, c32 * x * y * z);
    use(11, -c31 * y * (4 * zz - xx - yy));
    use(12, R(0.3731763325901154) * z * (2 * zz - 3 * xx - 3 * yy));  // sqrt(7 / (16 pi))
    use(13, -c31 * x * (4 * zz - xx - yy));
    use(14, c32 / 2 * z * (xx - yy));
    use(15, -c33 * x * (xx - 3 * yy));
}

// The colour, red, green and blue, at least 0, 1 being white, in the unit direction d from the eye
// to the splat: 1/2 + sum_k c_k Y_k(d), clamped at 0. at(k) returns c_k.  [Kerbl 2023]
template <class R, class At>
HD Vec3<R> sh_colour(int degree, Vec3<R> d, At&& at)
{
    Vec3<R> sum{R(0.5), R(0.5), R(0.5)};
    each_harmonic(degree, d, [&](int k, R y) { sum = sum + y * at(k); });
    return {max(sum.x, R(0)), max(sum.y, R(0)), max(sum.z, R(0))};
}

// Calls use(d, w) with the 26 directions and weights of a rule that integrates polynomials up to
// degree 7 over the unit sphere exactly.  [Lebedev 1976]
template <class R, class Use>
HD void each_lebedev(Use&& use)
{
    const R pi = R(3.14159265358979323846);
    const R to_face = 4 * pi / 21, to_edge = 16 * pi / 105, to_corner = 9 * pi / 70;
    for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j)
            for (int k = -1; k <= 1; ++k) {
                const int n = i * i + j * j + k * k;
                if (n == 0) continue;
                const R r = 1 / std::sqrt(R(n));
                use(Vec3<R>{R(i) * r, R(j) * r, R(k) * r}, n == 1   ? to_face
                                                           : n == 2 ? to_edge
                                                                    : to_corner);
            }
}

// Rotates the coefficients, to degree 3 at most, of a splat's colour by the rotation matrix Q:
// sum_k turned_k Y_k(Q d) = sum_k c_k Y_k(d). at(k) returns c_k, add(k, v) adds v to turned_k,
// which starts at 0. turned_k is the integral of Y_k(d) c(Q^T d), a polynomial of degree 6. For
// files: rendering rotates the direction by Q^T instead.
template <class R, class At, class Add>
HD void turn_harmonics(int degree, const Mat3<R>& Q, At&& at, Add&& add)
{
    const Mat3<R> back = transpose(Q);
    each_lebedev<R>([&](Vec3<R> d, R weight) {
        Vec3<R> colour{};
        each_harmonic(degree, back * d, [&](int k, R y) { colour = colour + y * at(k); });
        each_harmonic(degree, d, [&](int k, R y) { add(k, weight * y * colour); });
    });
}

}  // namespace knead
