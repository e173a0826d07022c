// Contact of bodies: clay of unlike colours has a velocity field each. Two fields at a node may
// separate and slide with Coulomb friction; they do not approach each other by more than the gap
// between the bodies.  (25a)
//
// A field extends 1.5 cells beyond the surface of its clay, so that two fields that approach at a
// node need not touch. The gap follows from the volume shares at the node and at its neighbours in
// the direction of the body with the smaller share.
#pragma once
#include <cstdint>

#include "cuda/contact/contact.h"
#include "cuda/contact/cut.h"
#include "cuda/math/node4.h"
#include "cuda/math/vec.h"

namespace knead {

// Velocity fields of bodies, and the fields in all: field 0 is of all clay. A colour has one field
// or, in scenes with blades, three: of its uncut clay, and of its clay with each label (cut.h).
constexpr int most_colours = 4, labels_of_clay = 3, most_fields = 1 + labels_of_clay * most_colours;

// Contact of objects of unlike category.
constexpr double most_body_friction = 2;

struct BodyContact {
    bool separate = false;  // false: all clay shares one velocity field
    double friction = 0.4;  // Coulomb [1]
    bool operator==(const BodyContact&) const = default;
};

// Constants of the stage.
template <class R>
struct BodyFields {
    int colours;  // 2 to most_colours; 0: one field
    R friction;
    R per_full[1 + most_colours];  // by colour: 1 / mass of a node in full clay [1/kg]
    int labels;                    // fields of a colour: 1 or labels_of_clay

    HD int count() const { return 1 + colours * labels; }                 // of fields
    HD int first(int colour) const { return 1 + (colour - 1) * labels; }  // of a colour's fields
};

// Share of the full mass of a node `t` cells below the surface of a half space: the integral of the
// quadratic B-spline (1) from -1.5 to t.
template <class R>
HD R share_below(R t)
{
    if (!(t > R(-1.5))) return 0;
    if (t >= R(1.5)) return 1;
    const R end = R(1.5) - (t < 0 ? -t : t), rest = end * end * end / 6;
    if (t <= R(-0.5)) return rest;
    if (t >= R(0.5)) return 1 - rest;
    return R(0.5) + t * (R(0.75) - t * t / 3);
}
// Its derivative, the B-spline.
template <class R>
HD R spline(R t)
{
    const R s = t < 0 ? -t : t;
    if (s < R(0.5)) return R(0.75) - s * s;
    return s < R(1.5) ? R(0.5) * (R(1.5) - s) * (R(1.5) - s) : R(0);
}

// Depth T [cells] of a node below a surface, from the ratio r of its share to that of a node `h`
// cells deeper: share(T) = r share(T + h). -1.5 for r = 0, 1.5 for r >= 1. To 1e-5 cells:
// bisection, then Newton steps.
template <class R>
HD R depth_of_ratio(R r, R h)
{
    if (!(r > 0)) return R(-1.5);
    if (r >= 1) return R(1.5);
    R low = R(-1.5), high = R(1.5);
    ROLLED
    for (int k = 0; k < 8; ++k) {
        const R middle = R(0.5) * (low + high);
        const bool below = share_below(middle) < r * share_below(middle + h);
        (below ? low : high) = middle;
    }
    R t = R(0.5) * (low + high);
    ROLLED
    for (int k = 0; k < 3; ++k) {
        const R rise = spline(t) - r * spline(t + h);
        if (!(rise > R(1e-4))) break;
        t = t - (share_below(t) - r * share_below(t + h)) / rise;
        t = min(max(t, low), high);
    }
    return t;
}

// Gap of two fields at a node.
template <class R>
struct Gap {
    Vec3<R> n;   // normal out of the clay of the first, towards the second
    R width;     // gap between the bodies [cells], 0 if they touch
    bool found;  // false: the shares have no direction
};

// Below this gap the bodies touch [cells].
constexpr double touching = 0.05;

// volume(f, step): volume share of field f (f = 0 or 1) at the node `step` from this one.
template <class R, class Volume>
HD Gap<R> gap_between(Volume&& volume)
{
    Vec3<R> slope[2] = {};
    ROLLED
    for (int k = 0; k < 9; ++k) {  // Sobel gradients: central differences, weighted (1 2 1) across
        const int i = k % 3 - 1, j = k / 3 - 1;
        const R w = R((i ? 1 : 2) * (j ? 1 : 2)) / 16;
        UNROLL
        for (int f = 0; f < 2; ++f)
            slope[f] = slope[f] + w * Vec3<R>{volume(f, {1, i, j}) - volume(f, {-1, i, j}),
                                              volume(f, {i, 1, j}) - volume(f, {i, -1, j}),
                                              volume(f, {i, j, 1}) - volume(f, {i, j, -1})};
    }
    const R a = dot(slope[0], slope[0]), b = dot(slope[1], slope[1]);
    if (!(a + b > 0)) return {{}, 0, false};
    const auto sharper =
        [](R share) {  // to the eighth power: nearly the normal of the sharper field
            const R square = share * share, fourth = square * square;
            return fourth * fourth;
        };
    const Vec3<R> towards = sharper(b / (a + b)) * slope[1] - sharper(a / (a + b)) * slope[0];
    const R size = length(towards);
    if (!(size > 0)) return {{}, 0, false};
    const Vec3<R> n = (1 / size) * towards, square = {n.x * n.x, n.y * n.y, n.z * n.z};
    const auto sign = [](R c) { return c < 0 ? -1 : 1; };
    const Int3 s = {sign(n.x), sign(n.y), sign(n.z)};
    const R h = square.x * (n.x < 0 ? -n.x : n.x) + square.y * (n.y < 0 ? -n.y : n.y) +
                square.z * (n.z < 0 ? -n.z : n.z);
    const R own_a = volume(0, {0, 0, 0}), own_b = volume(1, {0, 0, 0});
    // The neighbours' mean share, on the second field's side, or on the first one's.
    const bool first_fuller = own_a >= own_b;
    const int way = first_fuller ? 1 : -1;
    const auto beside = [&](int f) {
        return square.x * volume(f, {way * s.x, 0, 0}) + square.y * volume(f, {0, way * s.y, 0}) +
               square.z * volume(f, {0, 0, way * s.z});
    };
    const R next_a = beside(0), next_b = beside(1);
    const auto depth = [h](R share, R of) {
        return of > 0 ? depth_of_ratio(share / of, h) : R(1.5);
    };
    R sum;  // of the depths of the node below both surfaces; negative: a gap [cells]
    if (first_fuller)
        sum = (own_a > 0 ? h + depth_of_ratio(next_a / own_a, h) : R(1.5)) + depth(own_b, next_b);
    else
        sum = (own_b > 0 ? h + depth_of_ratio(next_b / own_b, h) : R(1.5)) + depth(own_a, next_a);
    return {n, max(R(0), -sum - R(touching)), true};
}

// Impulse that the first of two fields loses and the second gains [kg m/s]. `a` and `b`: momentum
// and mass. `approach`: closing speed that is still allowed [m/s].
template <class R>
HD Vec3<R> contact_impulse(const Node<R>& a, const Node<R>& b, Vec3<R> n, R approach, R friction)
{
    const auto velocity = [](const Node<R>& f) {
        return Vec3<R>{f.p.x / f.m, f.p.y / f.m, f.p.z / f.m};
    };
    const Vec3<R> v = velocity(a) - velocity(b);
    const R closing = dot(v, n), excess = closing - approach;
    if (!(excess > 0)) return {};
    const R mass = a.m * (b.m / (a.m + b.m));
    const Vec3<R> along = v - closing * n;
    const R speed = length(along), normal = mass * excess;
    Vec3<R> impulse = normal * n;
    if (speed > 0) impulse = impulse + (min(friction * normal, mass * speed) / speed) * along;
    return impulse;
}

// A colour's clay at a node of a scene with blades, by its three fields. Where uncut clay is left,
// as ahead of a blade's edge, all of it is one body. Otherwise clay of both labels is two.  (25)
template <class R>
struct LabelledClay {
    R uncut_mass, above_mass, below_mass;  // [kg]
    HD R mass() const { return uncut_mass + above_mass + below_mass; }
    HD bool bridged() const { return uncut_mass > R(bridge) * mass(); }
    HD bool parted() const { return above_mass > 0 && below_mass > 0 && !bridged(); }
};
template <class R, class Mass>
HD LabelledClay<R> labelled_clay(const BodyFields<R>& fields, int colour, Mass&& mass)
{
    const int first = fields.first(colour);
    return {mass(first + int(uncut)), mass(first + int(above)), mass(first + int(below))};
}

// Gives the fields of a colour that act as one at a node their common velocity: all three, or uncut
// clay that of the sides of a cut, with their loss. Conserves momentum to rounding.
// momentum(f), add(f, impulse): of field f.
template <class R, class Momentum, class Add>
HD void weld_labels(int first, const LabelledClay<R>& clay, Momentum&& momentum, Add&& add)
{
    const R m[labels_of_clay] = {clay.uncut_mass, clay.above_mass, clay.below_mass};
    const bool parted = clay.parted();
    if (int(m[0] > 0) + int(m[1] > 0) + int(m[2] > 0) < 2 || (parted && !(m[0] > 0))) return;
    Vec3<R> sum{};
    UNROLL
    for (int k = 0; k < labels_of_clay; ++k)
        if (m[k] > 0) sum = sum + momentum(first + k);
    const Vec3<R> v = (1 / clay.mass()) * sum;
    UNROLL
    for (int k = 0; k < labels_of_clay; ++k)
        if (m[k] > 0 && !(parted && k != int(uncut))) {
            const Vec3<R> change = m[k] * v - momentum(first + k);
            add(first + k, change);
            if (!parted) continue;
            const R share = m[1] / (m[1] + m[2]);
            add(first + int(above), -share * change), add(first + int(below), (share - 1) * change);
        }
}

// The same for velocities, after walls and tools. get(f), put(f, node): velocity and mass of field
// f.
template <class R, class Get, class Put>
HD void weld_velocities(int first, Get&& get, Put&& put)
{
    const LabelledClay<R> clay{get(first + int(uncut)).m, get(first + int(above)).m,
                               get(first + int(below)).m};
    weld_labels(
        first, clay,
        [&](int f) {
            const Node<R> of = get(f);
            return of.m * of.p;
        },
        [&](int f, Vec3<R> impulse) {
            const Node<R> of = get(f);
            put(f, Node<R>{of.p + (1 / of.m) * impulse, of.m});
        });
}

// Fields that are one body at a node: `count` fields of a colour from field `from`; 0: no clay.
struct BodyPart {
    int from, count, colour;
};

// Contact of all bodies at a node, before gravity, tools and walls. mass(f, step): mass of field f
// at the node `step` from this one [kg]; momentum(f): its momentum here; add(f, impulse) changes
// that. Pairs are taken in order, twice if there are three or more bodies. Each pair conserves
// momentum to rounding. `labels`: of the fields; with three, the two sides of a cut are bodies, and
// fields that act as one get one velocity.
template <int labels, class R, class Mass, class Momentum, class Add>
HD void separate_fields(const BodyFields<R>& fields, R dx, R dt, Mass&& mass, Momentum&& momentum,
                        Add&& add)
{
    constexpr int sides = labels > 1 ? 2 : 1;
    unsigned parted = 0;  // bits of colours
    if constexpr (labels > 1) ROLLED
    for (int c = 1; c <= fields.colours; ++c)
        if (labelled_clay(fields, c, [&](int f) { return mass(f, Int3{}); }).parted())
            parted |= 1u << c;
    const auto part = [&](int k) -> BodyPart {
        if constexpr (labels == 1) return {1 + k, 1, 1 + k};
        const int c = 1 + k / sides, side = k % sides, first = 1 + (c - 1) * labels;
        if (parted >> c & 1) return {first + 1 + side, 1, c};
        return {first, side ? 0 : labels, c};
    };
    const auto mass_of = [&](const BodyPart& p, Int3 step) {
        if constexpr (labels == 1) return mass(p.from, step);
        R sum = 0;
        ROLLED
        for (int k = 0; k < p.count; ++k) sum += mass(p.from + k, step);
        return sum;
    };
    const auto momentum_of = [&](const BodyPart& p) {
        if constexpr (labels == 1) return momentum(p.from);
        Vec3<R> sum{};
        ROLLED
        for (int k = 0; k < p.count; ++k) sum = sum + momentum(p.from + k);
        return sum;
    };
    // A field with mass, for the impulse of a part; fields of a part are welded afterwards.
    const auto field_of = [&](const BodyPart& p) {
        if constexpr (labels > 1) ROLLED
        for (int k = 0; k + 1 < p.count; ++k)
            if (mass(p.from + k, Int3{}) > 0) return p.from + k;
        return p.from + p.count - 1;
    };
    const int parts = sides * fields.colours;
    int here = 0;
    ROLLED
    for (int k = 0; k < parts; ++k) here += mass_of(part(k), Int3{}) > 0;
    ROLLED
    for (int sweep = here < 2 ? 2 : here > 2 ? 0 : 1; sweep < 2; ++sweep) ROLLED
    for (int i = 0; i + 1 < parts; ++i) ROLLED
    for (int j = i + 1; j < parts; ++j) {
        const BodyPart a = part(i), b = part(j);
        const R mass_a = mass_of(a, Int3{}), mass_b = mass_of(b, Int3{});
        if (!(mass_a > 0 && mass_b > 0)) continue;
        const Gap<R> gap = gap_between<R>([&](int f, Int3 step) {
            return f ? fields.per_full[b.colour] * mass_of(b, step)
                     : fields.per_full[a.colour] * mass_of(a, step);
        });
        if (!gap.found) continue;
        const Vec3<R> impulse =
            contact_impulse(Node<R>{momentum_of(a), mass_a}, Node<R>{momentum_of(b), mass_b}, gap.n,
                            gap.width * dx / dt, fields.friction);
        if (impulse.x == 0 && impulse.y == 0 && impulse.z == 0) continue;
        add(field_of(a), -impulse), add(field_of(b), impulse);
    }
    if constexpr (labels > 1) ROLLED
    for (int c = 1; c <= fields.colours; ++c)
        weld_labels(fields.first(c),
                    labelled_clay(fields, c, [&](int f) { return mass(f, Int3{}); }), momentum,
                    add);
}

}  // namespace knead
