// Rotations as unit quaternions and as matrices.
#pragma once
#include "cuda/math/vec.h"

namespace knead {

// The matrix of a unit quaternion: its columns are the images of the axes.
template <class R>
HD Mat3<R> rotation(Quat<R> q)
{
    return {rotate(q, Vec3<R>{1, 0, 0}), rotate(q, Vec3<R>{0, 1, 0}), rotate(q, Vec3<R>{0, 0, 1})};
}

// The rotation whose matrix is A, by the largest of its four components.  [Shepperd 1978]
template <class R>
HD Quat<R> quaternion(const Mat3<R>& A)
{
    const R xx = A.a.x, yy = A.b.y, zz = A.c.z, t = xx + yy + zz;
    const R yz = A.b.z - A.c.y, zx = A.c.x - A.a.z, xy = A.a.y - A.b.x;
    if (t >= max(xx, max(yy, zz))) return unit(Quat<R>{1 + t, yz, zx, xy});
    if (xx >= max(yy, zz)) return unit(Quat<R>{yz, 1 + 2 * xx - t, A.a.y + A.b.x, A.a.z + A.c.x});
    if (yy >= zz) return unit(Quat<R>{zx, A.a.y + A.b.x, 1 + 2 * yy - t, A.b.z + A.c.y});
    return unit(Quat<R>{xy, A.a.z + A.c.x, A.b.z + A.c.y, 1 + 2 * zz - t});
}

}  // namespace knead
