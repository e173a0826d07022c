// Contact with moving tools: the nearest of a block's candidate primitives, the contact response of
// a velocity, and the selection of a block's candidates.  (16)-(19)
#pragma once
#include <cstdint>

#include "cuda/contact/medial.h"
#include "cuda/contact/skinning.h"
#include "cuda/math/span.h"

namespace knead {

// Contact law of a surface.
enum class ContactMode : int { sticky, slip, separate };

// A hand or a held tool: a set of primitives with one contact law.
template <class R>
struct Tool {
    ContactMode mode;
    R friction;   // Coulomb [1]
    bool blade;   // thinner than the lattice resolves: two-sided treatment, see cuda/contact/cut.h
    bool active;  // false: passes through everything (not tracked, just reappeared)
    R size = 1;   // scale of its radii; a tool that reappears inside clay grows
    Stretch<R> stretch{};
};

// Contact candidates of a block of 4^3 cells: one bit per primitive.
constexpr int mask_words = 8, max_primitives = 32 * mask_words;
struct alignas(16) Mask {
    std::uint32_t bits[mask_words];
};
HD bool empty(const Mask& mask)
{
    std::uint32_t all = 0;
    UNROLL
    for (int word = 0; word < mask_words; ++word) all |= mask.bits[word];
    return all == 0;
}

// All tools at one instant.
template <class R>
struct Colliders {
    Span<const Sphere<R>> spheres;
    Span<const Primitive> primitives;
    Span<const Shape<R>> shapes;  // one per primitive
    Span<const Tool<R>> tools;
};

// A set of tools as bits: those from the 31st on share the last bit.
HD std::uint32_t tool_bit(int tool) { return 1u << min(tool, 31); }

template <class R>
struct Contact {
    R phi;      // signed distance [m]
    Vec3<R> n;  // outward unit normal
    Vec3<R> v;  // velocity of the tool's surface there [m/s]
    int tool;   // -1: none
};

// Velocity of the surface at a closest point: the spheres' motion blended, and their spin about
// the centre.
template <class R>
HD Vec3<R> surface_velocity(const Colliders<R>& c, const Primitive& q, const ClosestPoint<R>& f)
{
    const Sphere<R>&s0 = c.spheres[q.sphere[0]], &s1 = c.spheres[q.sphere[1]],
          &s2 = c.spheres[q.sphere[2]];
    const R r = f.blend(s0.r, s1.r, s2.r);
    const R rate = f.blend(s0.rate, s1.rate, s2.rate);
    const Vec3<R> v = f.blend(s0.v, s1.v, s2.v);
    const Vec3<R> w = f.blend(s0.w, s1.w, s2.w);
    return v + cross(w, r * f.n) + rate * f.n;
}

// Calls visit(primitive index) for every set bit, in order.
template <class Visit>
HD void for_each_candidate(const Mask& mask, Visit&& visit)
{
    for (int word = 0; word < mask_words; ++word)
        for (std::uint32_t bits = mask.bits[word]; bits; bits &= bits - 1)
            visit(32 * word + lowest_bit(bits));
}

// Whether a primitive is a blade, with contact on both sides: see cuda/contact/cut.h.
template <class R>
HD bool two_sided(const Colliders<R>& c, int primitive)
{
    return c.tools[c.primitives[primitive].tool].blade && c.shapes[primitive].plane;
}

// The nearest of the mask's primitives at p for which `admits(shape)` holds, without blades.
// `grown`: added to their radii [m].
template <class R, class Admits>
HD Contact<R> nearest_of(const Colliders<R>& c, const Mask& mask, Vec3<R> p, R grown,
                         Admits&& admits)
{
    ClosestPoint<R> best{R(1e30), {0, 1, 0}, 1, 0, 0};
    int at = -1;
    for_each_candidate(mask, [&](int i) {
        if (!admits(c.shapes[i])) return;
        if (two_sided(c, i)) return;
        const ClosestPoint<R> f = closest_point(c.shapes[i], p);
        if (f.phi < best.phi) best = f, at = i;
    });
    if (at < 0) return {best.phi, best.n, {0, 0, 0}, -1};
    return {best.phi - grown, best.n, surface_velocity(c, c.primitives[at], best),
            c.primitives[at].tool};
}

// Of all the mask's primitives, at any distance.
template <class R>
HD Contact<R> nearest(const Colliders<R>& c, const Mask& mask, Vec3<R> p)
{
    return nearest_of(c, mask, p, R(0), [](const Shape<R>&) { return true; });
}

// As nearest(), but only of the primitives that may contain p. Equals nearest() if p is inside any;
// else phi >= 0 and the other members are not valid.
template <class R>
HD Contact<R> deepest_contact(const Colliders<R>& c, const Mask& mask, Vec3<R> p,
                              std::type_identity_t<R> grown = 0)
{
    return nearest_of(c, mask, p, grown, [&](const Shape<R>& s) { return enclosed(s, p, grown); });
}

// Velocity of clay that slides at `along`, of length `speed`, over a surface moving at u, after
// friction has reduced the speed by `by` [m/s].
template <class R>
HD Vec3<R> after_friction(Vec3<R> along, R speed, Vec3<R> u, R by)
{
    const R left = speed - by;
    if (left <= 0) return u;
    return u + (left / speed) * along;
}

// Applies contact with a surface of outward normal n, moving at u, to the velocity v.  (18)
template <class R>
HD Vec3<R> apply_contact(Vec3<R> v, Vec3<R> n, Vec3<R> u, ContactMode mode, R friction)
{
    const Vec3<R> rel = v - u;
    const R vn = dot(rel, n);
    if (mode == ContactMode::sticky) return vn < 0 ? u : v;
    const Vec3<R> along = rel - vn * n;
    if (mode == ContactMode::slip) return u + along;
    if (vn >= 0) return v;
    return after_friction(along, length(along), u, friction * -vn);
}

// Whether a primitive can come within `band` of a cube with centre p and edge `edge`.
template <class R>
HD bool reaches(const Shape<R>& s, Vec3<R> p, R edge, R band)
{
    return closest_point(s, p).phi <= R(0.8660254038) * edge + band;
}

}  // namespace knead
