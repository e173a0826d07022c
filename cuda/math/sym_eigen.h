// Eigenvalues and axes of a symmetric 3 x 3 matrix by cyclic Jacobi sweeps.  [Golub & Van Loan 8.5]
#pragma once
#include "cuda/math/vec.h"

namespace knead {

template <class R>
struct Eigen {
    Vec3<R> value;
    Mat3<R> axes;  // orthonormal columns, in the order of the values
};

// Rotates the plane of axes u and v so that the element `off` between them vanishes; `p` and `q`
// are the diagonal elements, `s` and `t` the elements that couple u and v to the third axis.
template <class R>
HD void turn(R& p, R& q, R& off, R& s, R& t, Vec3<R>& u, Vec3<R>& v)
{
    if (off == 0) return;
    const R theta = (q - p) / (2 * off);
    const R root = std::sqrt(theta * theta + 1);
    const R tan = theta < 0 ? 1 / (theta - root) : 1 / (theta + root);
    const R c = 1 / std::sqrt(tan * tan + 1), sn = tan * c;
    p = p - tan * off;
    q = q + tan * off;
    off = 0;
    const R s0 = s;
    s = c * s0 - sn * t;
    t = sn * s0 + c * t;
    const Vec3<R> u0 = u;
    u = c * u0 - sn * v;
    v = sn * u0 + c * v;
}

template <class R>
HD Eigen<R> eigen(Sym3<R> A)
{
    Mat3<R> Q = diagonal(R(1));
    constexpr int sweeps = sizeof(R) == 4 ? 4 : 6;  // the off-diagonal shrinks quadratically
    for (int k = 0; k < sweeps; ++k) {
        turn(A.xx, A.yy, A.xy, A.xz, A.yz, Q.a, Q.b);
        turn(A.xx, A.zz, A.xz, A.xy, A.yz, Q.a, Q.c);
        turn(A.yy, A.zz, A.yz, A.xy, A.xz, Q.b, Q.c);
    }
    return {{A.xx, A.yy, A.zz}, Q};
}

// Q diag(d) Q^T
template <class R>
HD Sym3<R> composed(const Mat3<R>& Q, Vec3<R> d)
{
    const Mat3<R> rows = transpose(Q);
    const auto at = [&](Vec3<R> u, Vec3<R> v) {
        return d.x * u.x * v.x + d.y * u.y * v.y + d.z * u.z * v.z;
    };
    return {at(rows.a, rows.a), at(rows.b, rows.b), at(rows.c, rows.c),
            at(rows.a, rows.b), at(rows.a, rows.c), at(rows.b, rows.c)};
}

}  // namespace knead
