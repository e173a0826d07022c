// Three-dimensional algebra for host and device, in float and double. No operator[]: a run-time
// index would move a register array to local memory.
#pragma once
#include <cmath>

#include "cuda/math/hd.h"

namespace knead {

template <class R>
struct Vec3 {
    R x, y, z;
};
template <class R>
struct Mat3 {
    Vec3<R> a, b, c;  // columns
};
template <class R>
struct Sym3 {
    R xx, yy, zz, xy, xz, yz;
};
template <class R>
struct Quat {
    R w, x, y, z;  // unit, unless stated otherwise
};
struct Int3 {
    int x, y, z;
};

// The component along axis 0, 1 or 2.
HD int component(Int3 a, int axis) { return axis == 0 ? a.x : axis == 1 ? a.y : a.z; }

HD Int3 operator+(Int3 a, Int3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
HD Int3 operator-(Int3 a, Int3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
HD Int3 operator*(int s, Int3 a) { return {s * a.x, s * a.y, s * a.z}; }
HD bool operator==(Int3 a, Int3 b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

// Whether node n is in a lattice of this size.
HD bool within(Int3 n, Int3 size)
{
    return n.x >= 0 && n.y >= 0 && n.z >= 0 && n.x < size.x && n.y < size.y && n.z < size.z;
}

template <class R>
HD R min(R a, R b)
{
    return b < a ? b : a;
}
template <class R>
HD R max(R a, R b)
{
    return a < b ? b : a;
}
template <class R>
HD R clamp(R a, R low, R high)
{
    return min(max(a, low), high);
}

template <class R>
HD Vec3<R> operator+(Vec3<R> u, Vec3<R> v)
{
    return {u.x + v.x, u.y + v.y, u.z + v.z};
}
template <class R>
HD Vec3<R> operator-(Vec3<R> u, Vec3<R> v)
{
    return {u.x - v.x, u.y - v.y, u.z - v.z};
}
template <class R>
HD Vec3<R> operator-(Vec3<R> u)
{
    return {-u.x, -u.y, -u.z};
}
template <class R>
HD Vec3<R> operator*(R s, Vec3<R> v)
{
    return {s * v.x, s * v.y, s * v.z};
}
template <class R>
HD R dot(Vec3<R> u, Vec3<R> v)
{
    return u.x * v.x + u.y * v.y + u.z * v.z;
}
template <class R>
HD Vec3<R> cross(Vec3<R> u, Vec3<R> v)
{
    return {u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
}
template <class R>
HD R length(Vec3<R> u)
{
    return std::sqrt(dot(u, u));
}
// A unit vector orthogonal to the unit vector u.
template <class R>
HD Vec3<R> orthogonal(Vec3<R> u)
{
    const Vec3<R> axis = u.x * u.x < R(0.5) ? Vec3<R>{1, 0, 0} : Vec3<R>{0, 1, 0};
    const Vec3<R> n = cross(u, axis);
    return (1 / length(n)) * n;
}

template <class R>
HD Mat3<R> operator+(const Mat3<R>& A, const Mat3<R>& B)
{
    return {A.a + B.a, A.b + B.b, A.c + B.c};
}
template <class R>
HD Mat3<R> operator-(const Mat3<R>& A, const Mat3<R>& B)
{
    return {A.a - B.a, A.b - B.b, A.c - B.c};
}
template <class R>
HD Mat3<R> operator*(R s, const Mat3<R>& A)
{
    return {s * A.a, s * A.b, s * A.c};
}
template <class R>
HD Vec3<R> operator*(const Mat3<R>& A, Vec3<R> v)
{
    return v.x * A.a + v.y * A.b + v.z * A.c;
}
template <class R>
HD Mat3<R> operator*(const Mat3<R>& A, const Mat3<R>& B)
{
    return {A * B.a, A * B.b, A * B.c};
}
template <class R>
HD Mat3<R> transpose(const Mat3<R>& A)
{
    return {{A.a.x, A.b.x, A.c.x}, {A.a.y, A.b.y, A.c.y}, {A.a.z, A.b.z, A.c.z}};
}
template <class R>
HD Mat3<R> outer(Vec3<R> u, Vec3<R> v)
{
    return {v.x * u, v.y * u, v.z * u};
}
template <class R>
HD Mat3<R> diagonal(R s)
{
    return {{s, 0, 0}, {0, s, 0}, {0, 0, s}};
}
template <class R>
HD R determinant(const Mat3<R>& A)
{
    return dot(A.a, cross(A.b, A.c));
}
template <class R>
HD Mat3<R> skew(const Mat3<R>& A)  // the antisymmetric part: a rigid spin
{
    return R(0.5) * (A - transpose(A));
}

template <class R>
HD Sym3<R> operator+(const Sym3<R>& A, const Sym3<R>& B)
{
    return {A.xx + B.xx, A.yy + B.yy, A.zz + B.zz, A.xy + B.xy, A.xz + B.xz, A.yz + B.yz};
}
template <class R>
HD Sym3<R> operator*(R s, const Sym3<R>& A)
{
    return {s * A.xx, s * A.yy, s * A.zz, s * A.xy, s * A.xz, s * A.yz};
}
template <class R>
HD Sym3<R> isotropic(R s)
{
    return {s, s, s, 0, 0, 0};
}
template <class R>
HD R trace(const Sym3<R>& A)
{
    return A.xx + A.yy + A.zz;
}
template <class R>
HD Sym3<R> raised(const Sym3<R>& A, R s)  // A + s I
{
    return {A.xx + s, A.yy + s, A.zz + s, A.xy, A.xz, A.yz};
}
template <class R>
HD Sym3<R> deviator(const Sym3<R>& A)
{
    return raised(A, -(R(1) / 3) * trace(A));
}
template <class R>
HD R norm_squared(const Sym3<R>& A)  // Frobenius
{
    return A.xx * A.xx + A.yy * A.yy + A.zz * A.zz + 2 * (A.xy * A.xy + A.xz * A.xz + A.yz * A.yz);
}
template <class R>
HD R determinant(const Sym3<R>& A)
{
    return A.xx * (A.yy * A.zz - A.yz * A.yz) - A.xy * (A.xy * A.zz - A.yz * A.xz) +
           A.xz * (A.xy * A.yz - A.yy * A.xz);
}
// Sum of the principal 2 x 2 minors (the second invariant).
template <class R>
HD R minors(const Sym3<R>& A)
{
    return A.xx * A.yy + A.yy * A.zz + A.zz * A.xx - A.xy * A.xy - A.xz * A.xz - A.yz * A.yz;
}
// det(I + A) - 1 without cancellation.
template <class R>
HD R determinant_excess(const Sym3<R>& A)
{
    return trace(A) + minors(A) + determinant(A);
}
template <class R>
HD Mat3<R> full(const Sym3<R>& A)
{
    return {{A.xx, A.xy, A.xz}, {A.xy, A.yy, A.yz}, {A.xz, A.yz, A.zz}};
}
template <class R>
HD Sym3<R> symmetric(const Mat3<R>& A)  // (A + A^T) / 2
{
    return {A.a.x,
            A.b.y,
            A.c.z,
            R(0.5) * (A.b.x + A.a.y),
            R(0.5) * (A.c.x + A.a.z),
            R(0.5) * (A.c.y + A.b.z)};
}

template <class R>
HD Quat<R> operator*(Quat<R> p, Quat<R> q)
{
    return {p.w * q.w - p.x * q.x - p.y * q.y - p.z * q.z,
            p.w * q.x + p.x * q.w + p.y * q.z - p.z * q.y,
            p.w * q.y - p.x * q.z + p.y * q.w + p.z * q.x,
            p.w * q.z + p.x * q.y - p.y * q.x + p.z * q.w};
}
template <class R>
HD Quat<R> conjugate(Quat<R> q)
{
    return {q.w, -q.x, -q.y, -q.z};
}
template <class R>
HD Vec3<R> rotate(Quat<R> q, Vec3<R> v)
{
    const Vec3<R> u{q.x, q.y, q.z};
    const Vec3<R> t = R(2) * cross(u, v);
    return v + q.w * t + cross(u, t);
}
// Normalises a quaternion; the identity if it is zero.
template <class R>
HD Quat<R> unit(Quat<R> q)
{
    const R n = std::sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
    if (!(n > 0)) return {1, 0, 0, 0};
    return {q.w / n, q.x / n, q.y / n, q.z / n};
}
// Interpolates from p (s = 0) to q (s = 1) along the shorter arc, by the normalised chord: within
// 0.02 degrees of slerp for the rotations of one frame (< 30 degrees).
template <class R>
HD Quat<R> between(Quat<R> p, Quat<R> q, R s)
{
    const R turn = p.w * q.w + p.x * q.x + p.y * q.y + p.z * q.z;
    const R t = turn < 0 ? -s : s;
    return unit(Quat<R>{(1 - s) * p.w + t * q.w, (1 - s) * p.x + t * q.x, (1 - s) * p.y + t * q.y,
                        (1 - s) * p.z + t * q.z});
}
template <class R>
HD Quat<R> turn_about(Vec3<R> axis, R angle)  // axis of unit length, angle in radians
{
    const R s = std::sin(angle / 2);
    return {std::cos(angle / 2), s * axis.x, s * axis.y, s * axis.z};
}

template <class To, class R>
HD Vec3<To> cast(Vec3<R> v)
{
    return {To(v.x), To(v.y), To(v.z)};
}
template <class To, class R>
HD Quat<To> cast(Quat<R> q)
{
    return {To(q.w), To(q.x), To(q.y), To(q.z)};
}

}  // namespace knead
