#include "host/files/splat_axes.h"

#include <cmath>

#include "cuda/splats/footprint.h"

namespace knead {
namespace {

// Along which axes harmonic k is odd.
constexpr const char* odd_along[16] = {"", "y", "z",   "x", "xy", "yz", "",  "xz",
                                       "", "y", "xyz", "y", "z",  "x",  "z", "x"};

double component(Vec3<double> v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }
double& component_of(Vec3<double>& v, int axis) { return axis == 0 ? v.x : axis == 1 ? v.y : v.z; }

Mat3<double> scaled(double s, const Mat3<double>& A) { return {s * A.a, s * A.b, s * A.c}; }

}  // namespace

HarmonicTurn::HarmonicTurn(const Mat3<double>& Q)
{
    // A reflection is the rotation -Q and a point reflection, which negates odd degrees.
    const double handedness = determinant(Q) < 0 ? -1 : 1;
    const Mat3<double> proper = scaled(handedness, Q);
    for (std::size_t j = 0; j < 16; ++j) {
        const double odd = (j >= 1 && j < 4) || j >= 9 ? handedness : 1;
        turn_harmonics(
            max_sh_degree, proper,
            [&](int k) {
                return Vec3<double>{std::size_t(k) == j ? 1.0 : 0.0, 0, 0};
            },
            [&](int k, Vec3<double> v) { turned[std::size_t(k)][j] += odd * v.x; });
    }
}

SplatAxes::SplatAxes(const char* letters)
{
    Vec3<double> columns[3] = {};
    for (std::size_t k = 0; k < 3; ++k) {
        const char c = letters[k];
        axis[k] = c == 'L' || c == 'R' ? 0 : c == 'U' || c == 'D' ? 1 : 2;
        direction[k] = c == 'R' || c == 'D' || c == 'F' ? 1 : -1;
        component_of(columns[k], axis[k]) = direction[k];
    }
    swapped = axis[1] != 1;
    const Mat3<double> m{columns[0], columns[1], columns[2]};
    handedness = determinant(m);
    for (std::size_t k = 0; k < 16; ++k) {
        sign[k] = 1;
        for (const char* c = odd_along[k]; *c; ++c) sign[k] *= direction[std::size_t(*c - 'x')];
    }
    if (swapped) harmonics_turn = HarmonicTurn(m);
}

Vec3<double> SplatAxes::place(Vec3<double> x) const
{
    Vec3<double> out{};
    for (std::size_t k = 0; k < 3; ++k)
        component_of(out, axis[k]) = 0 + direction[k] * component(x, int(k));  // never -0
    return out;
}

// M R M^T has the vector part det(M) M v.
Quat<double> SplatAxes::turn(Quat<double> q) const
{
    const Vec3<double> v = handedness * place({q.x, q.y, q.z});
    return {q.w, v.x, v.y, v.z};
}

Vec3<double> SplatAxes::half_axes(Vec3<double> s) const
{
    return swapped ? Vec3<double>{s.x, s.z, s.y} : s;
}

const char* spz_axes(unsigned system)
{
    constexpr const char* letters[16] = {"LDB", "RDB", "LUB", "RUB", "LDF", "RDF", "LUF", "RUF",
                                         "LFD", "RFD", "LFU", "RFU", "LBD", "RBD", "LBU", "RBU"};
    return letters[(system - 1) % 16];
}

SplatTransform::SplatTransform(const Mat3<double>& M, Vec3<double> shift) : matrix(M), move(shift)
{
    const double handedness = determinant(M) < 0 ? -1 : 1;
    const Mat3<double> R = polar_rotation(scaled(handedness, M));
    scale = std::cbrt(std::abs(determinant(M)));
    const Mat3<double> rest = scaled(handedness, M) - scaled(scale, R);
    const double apart = std::sqrt(dot(rest.a, rest.a) + dot(rest.b, rest.b) + dot(rest.c, rest.c));
    // An ellipsoid is its own point reflection.
    similar = apart <= 1e-9 * scale;
    rotation_of_m = quaternion(R);
    turn = HarmonicTurn(scaled(handedness, R));
}

Ellipsoid<double> SplatTransform::apply(const Ellipsoid<double>& e) const
{
    const Vec3<double> s = e.scale;
    if (similar) return {rotation_of_m * e.q, scale * s};
    const Mat3<double> Q = rotation(unit(e.q)),
                       L = matrix * Mat3<double>{s.x * Q.a, s.y * Q.b, s.z * Q.c};
    return ellipsoid(symmetric(L * transpose(L)));
}

}  // namespace knead
