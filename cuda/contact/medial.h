// Exact signed distance to medial primitives: balls, cones (two spheres) and slabs (three), each
// the convex hull of its spheres.  (12)-(15); degenerate cases as in docs/method/model.md.
#pragma once
#include "cuda/math/vec.h"

namespace knead {

// A moving medial sphere at one instant. Aligned, like the structures below, for 16-byte loads.
template <class R>
struct alignas(16) Sphere {
    Vec3<R> c, v, w;  // centre [m], velocity [m/s], angular velocity [1/s]
    R r, rate;        // radius [m] and its rate of change [m/s]
};

struct alignas(16) Primitive {
    int count;      // 1 ball, 2 cone, 3 slab
    int sphere[3];  // indices of its spheres; unused ones repeat the last
    int tool;       // index of the tool it belongs to
};

// The side of a cone, derived once per pose. A cone without a tangent line is its larger sphere.
template <class R>
struct alignas(16) Cone {
    Vec3<R> a, u;      // first centre [m], unit axis
    R length, r;       // length of the axis, radius of the first sphere [m]
    R k, kc;           // radius per length, and k / sqrt(1 - k^2)
    R start, inverse;  // weight of the second sphere at s: start + s * inverse
};

// A primitive's derived constants.
template <class R>
struct alignas(16) Shape {
    Vec3<R> low;      // of its bounding box [m]
    int count;        // 1 ball, 2 cone, 3 slab
    Vec3<R> high;     // [m]
    bool plane;       // slab: two tangent planes exist
    Vec3<R> c0;       // slab: first centre; else that of edge[0] [m]
    R reach;          // see enclosed() [m]
    Vec3<R> N;        // unit normal of the plane; a cone's unit axis; else 0
    R r0;             // slab: first radius [m]
    Cone<R> edge[3];  // (0,1), (1,2), (0,2)
    Vec3<R> g;        // slab: gradient of the radius
    R k1;             // see (14)
    Vec3<R> m1;       // slab: dual vectors of its sides [1/m]
    R k2;
    Vec3<R> m2;
    R cc;
};

// Conservative test whether p is inside the primitive, grown by `grown` [m]: inside the bounding
// box, and within a slab's tangent planes, or within the larger radius of a cone's axis.
template <class R>
HD bool enclosed(const Shape<R>& s, Vec3<R> p, std::type_identity_t<R> grown = 0)
{
    const Vec3<R> d = p - s.c0;
    const R t = dot(d, s.N), g = grown, far = s.reach + g;
    const bool near =
        s.plane ? s.cc * (t < 0 ? -t : t) - dot(s.g, d) <= far : dot(d, d) - t * t <= far * far;
    return (p.x >= s.low.x - g) & (p.x <= s.high.x + g) & (p.y >= s.low.y - g) &
           (p.y <= s.high.y + g) & (p.z >= s.low.z - g) & (p.z <= s.high.z + g) & near;
}

// The closest point: signed distance, outward normal, weights of the spheres.
template <class R>
struct ClosestPoint {
    R phi;         // [m], negative inside
    Vec3<R> n;     // unit
    R l0, l1, l2;  // sum 1
    // Interpolates values of the spheres by these weights.
    template <class V>
    HD V blend(const V& a, const V& b, const V& c) const
    {
        return l0 * a + l1 * b + l2 * c;
    }
};

// How close to 1 the squared slope of the radius may be before only the largest sphere counts, and
// how thin a slab may be relative to its longest side before only its sides count. Chosen where the
// error of neglecting the surface equals the rounding error.
template <class R>
constexpr R steep = sizeof(R) == 4 ? R(1e-6) : R(1e-12);
template <class R>
constexpr R thin = sizeof(R) == 4 ? R(2e-5) : R(3e-11);

template <class R>
HD Cone<R> cone(Vec3<R> a, R ra, Vec3<R> b, R rb)
{
    const Vec3<R> d = b - a;
    const R square = dot(d, d), dr = rb - ra;
    if (!(square > 0) || dr * dr >= (1 - steep<R>)*square) {
        const bool second = rb > ra;
        return {second ? b : a, {1, 0, 0}, 0, second ? rb : ra, 0, 0, R(second ? 1 : 0), 0};
    }
    const R length = std::sqrt(square), k = dr / length;
    return {a, (1 / length) * d, length, ra, k, k / std::sqrt((1 - k) * (1 + k)), 0, 1 / length};
}

// Closest point of a cone (13); l0 and l1 are the weights of its first and second sphere.
template <class R>
HD ClosestPoint<R> closest_point(const Cone<R>& c, Vec3<R> p)
{
    const Vec3<R> d = p - c.a;
    const R x = dot(d, c.u);
    const R y = length(d - x * c.u);
    const R s = clamp(x + c.kc * y, R(0), c.length);
    const Vec3<R> from = d - s * c.u;
    const R D = length(from);
    const R t = c.start + s * c.inverse;
    constexpr R rounding = sizeof(R) == 4 ? R(1e-6) : R(1e-15);
    if (!(D > rounding * c.length)) {  // on the axis all directions to its side are equivalent
        const Vec3<R> n = std::sqrt((1 - c.k) * (1 + c.k)) * orthogonal(c.u) - c.k * c.u;
        return {-c.r - c.k * s, n, 1 - t, t, 0};
    }
    const Vec3<R> n = (1 / D) * from;
    return {D - c.r - c.k * s, n, 1 - t, t, 0};
}

// The plane of a slab. Its frame is aligned with the longest side ab, so that precision is kept for
// slivers. ma, mb and mt are the gradients of the weights [1/m].
template <class R>
HD void sheet(Shape<R>& s, const Sphere<R>& a, const Sphere<R>& b, const Sphere<R>& t, Vec3<R>& ma,
              Vec3<R>& mb, Vec3<R>& mt)
{
    const Vec3<R> ab = b.c - a.c, at = t.c - a.c;
    const R L = length(ab);
    if (!(L > 0)) return;
    const Vec3<R> u = (1 / L) * ab;
    const R x = dot(at, u);
    const Vec3<R> off = at - x * u;
    const R height = length(off);
    if (!(height > thin<R> * L)) return;
    const R slope = (b.r - a.r) / L, rise = (t.r - a.r - slope * x) / height;
    const R q = slope * slope + rise * rise;
    if (!(q < 1 - steep<R>)) return;
    const Vec3<R> area = cross(u, off);
    s.N = (1 / length(area)) * area;
    const Vec3<R> f = cross(s.N, u);
    s.plane = true;
    s.g = slope * u + rise * f;
    s.cc = std::sqrt(1 - q);
    mt = (1 / height) * f;
    mb = (1 / L) * (u - x * mt);
    ma = -(mb + mt);
}

// Fills s in place: a returned Shape would not fit in registers.
template <class R>
HD void form(Shape<R>& s, int count, const Sphere<R>& s0, const Sphere<R>& s1, const Sphere<R>& s2)
{
    s.count = count;
    s.plane = false;
    s.N = {0, 0, 0};
    const auto each = [](Vec3<R> u, Vec3<R> v, auto pick) {
        return Vec3<R>{pick(u.x, v.x), pick(u.y, v.y), pick(u.z, v.z)};
    };
    const auto add = [&](const Sphere<R>& q) {
        s.low = each(s.low, q.c - Vec3<R>{q.r, q.r, q.r}, [](R a, R b) { return min(a, b); });
        s.high = each(s.high, q.c + Vec3<R>{q.r, q.r, q.r}, [](R a, R b) { return max(a, b); });
    };
    s.low = s.high = s0.c;
    add(s0), add(s1), add(s2);
    s.edge[0] = cone(s0.c, s0.r, count > 1 ? s1.c : s0.c, count > 1 ? s1.r : s0.r);
    const Vec3<R> size = s.high - s.low;
    // With a margin for rounding: no point inside may be rejected.
    const auto within = [&](R radius) { return R(1.0005) * radius + R(1e-3) * length(size); };
    s.c0 = s.edge[0].a;
    s.reach = within(max(s0.r, s1.r));
    if (count < 3) {
        if (s.edge[0].length > 0) s.N = s.edge[0].u;
        return;
    }
    s.edge[1] = cone(s1.c, s1.r, s2.c, s2.r);
    s.edge[2] = cone(s0.c, s0.r, s2.c, s2.r);
    const auto side = [](const Sphere<R>& a, const Sphere<R>& b) {
        return dot(b.c - a.c, b.c - a.c);
    };
    const R d01 = side(s0, s1), d12 = side(s1, s2), d20 = side(s2, s0);
    Vec3<R> m0{};
    if (d01 >= d12 && d01 >= d20)
        sheet(s, s0, s1, s2, m0, s.m1, s.m2);
    else if (d12 >= d20)
        sheet(s, s1, s2, s0, s.m1, s.m2, m0);
    else
        sheet(s, s2, s0, s1, s.m2, m0, s.m1);
    s.reach = within(s.plane ? s0.r : length(size));
    if (!s.plane) return;
    s.c0 = s0.c;
    s.r0 = s0.r;
    s.k1 = dot(s.m1, s.g) / s.cc;
    s.k2 = dot(s.m2, s.g) / s.cc;
}
template <class R>
HD Shape<R> shape(int count, const Sphere<R>& s0, const Sphere<R>& s1, const Sphere<R>& s2)
{
    Shape<R> s{};
    form(s, count, s0, s1, s2);
    return s;
}

// Signed distance, normal and weights at p. If p is on the medial sheet itself, the distance is
// exact and the normal is one of several equally valid normals (at a slab's border, one of its
// side).
template <class R>
HD ClosestPoint<R> closest_point(const Shape<R>& s, Vec3<R> p)
{
    ClosestPoint<R> best{R(1e30), {0, 1, 0}, 1, 0, 0};
    unsigned open = s.count == 3 ? 7 : 1;  // edges that may contain it
    if (s.plane) {
        const Vec3<R> d = p - s.c0;
        const R h = dot(d, s.N), H = h < 0 ? -h : h;
        const R l1 = dot(s.m1, d) + s.k1 * H, l2 = dot(s.m2, d) + s.k2 * H, l0 = 1 - l1 - l2;
        // The distance is convex in the weights, so the closest point lies on an edge whose
        // opposite weight is negative at the unconstrained minimum.
        open = unsigned(l2 < 0) | unsigned(l0 < 0) << 1 | unsigned(l1 < 0) << 2;
        const R side = h < 0 ? -s.cc : s.cc;
        if (l0 >= 0 && l1 >= 0 && l2 >= 0)
            best = {s.cc * H - dot(s.g, d) - s.r0, side * s.N - s.g, l0, l1, l2};
    }
    for (; open; open &= open - 1) {
        const int e = lowest_bit(open);
        const ClosestPoint<R> f = closest_point(s.edge[e], p);
        if (!(f.phi < best.phi)) continue;
        best = {f.phi, f.n, e == 1 ? 0 : f.l0,
                e == 0   ? f.l1
                : e == 1 ? f.l0
                         : 0,
                e == 0 ? 0 : f.l1};
    }
    return best;
}

}  // namespace knead
