// Axis-aligned boxes, for host and device.
#pragma once
#include <limits>

#include "cuda/math/vec.h"

namespace knead {

// The points x with low <= x <= high along each axis.
template <class R>
struct Box3 {
    Vec3<R> low, high;
};

// The smaller and the larger of each component; that of u if v has a NaN there.
template <class R>
HD Vec3<R> lesser(Vec3<R> u, Vec3<R> v)
{
    return {min(u.x, v.x), min(u.y, v.y), min(u.z, v.z)};
}
template <class R>
HD Vec3<R> greater(Vec3<R> u, Vec3<R> v)
{
    return {max(u.x, v.x), max(u.y, v.y), max(u.z, v.z)};
}

// The box without a point, to be grown.
template <class R>
HD Box3<R> empty_box()
{
    constexpr R most = std::numeric_limits<R>::max();
    return {{most, most, most}, {-most, -most, -most}};
}
template <class R>
HD bool empty(const Box3<R>& box)
{
    return !(box.low.x <= box.high.x && box.low.y <= box.high.y && box.low.z <= box.high.z);
}

// Enlarges a box to contain a point or another box; ignores NaN.
template <class R>
HD void grow(Box3<R>& box, Vec3<R> x)
{
    box = {lesser(box.low, x), greater(box.high, x)};
}
template <class R>
HD void grow(Box3<R>& box, const Box3<R>& other)
{
    box = {lesser(box.low, other.low), greater(box.high, other.high)};
}
// The box with a margin on each side.
template <class R>
HD Box3<R> expanded(const Box3<R>& box, R margin)
{
    const Vec3<R> more{margin, margin, margin};
    return {box.low - more, box.high + more};
}

template <class R>
HD bool contains(const Box3<R>& box, Vec3<R> x)  // false for NaN
{
    return x.x >= box.low.x && x.y >= box.low.y && x.z >= box.low.z && x.x <= box.high.x &&
           x.y <= box.high.y && x.z <= box.high.z;
}
template <class R>
HD Vec3<R> nearest(const Box3<R>& box, Vec3<R> x)  // point of the box; NaN stays
{
    return {clamp(x.x, box.low.x, box.high.x), clamp(x.y, box.low.y, box.high.y),
            clamp(x.z, box.low.z, box.high.z)};
}
// Whether two boxes share a point.
template <class R>
HD bool intersects(const Box3<R>& a, const Box3<R>& b)
{
    return a.low.x <= b.high.x && a.low.y <= b.high.y && a.low.z <= b.high.z &&
           a.high.x >= b.low.x && a.high.y >= b.low.y && a.high.z >= b.low.z;
}

template <class R>
HD Vec3<R> centre(const Box3<R>& box)
{
    return R(0.5) * (box.low + box.high);
}
// The lengths of the edges.
template <class R>
HD Vec3<R> edges(const Box3<R>& box)
{
    return box.high - box.low;
}
template <class R>
HD R longest_edge(const Box3<R>& box)
{
    const Vec3<R> d = edges(box);
    return max(d.x, max(d.y, d.z));
}

}  // namespace knead
