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
#include "cuda/math/node4.h"
#include "cuda/math/vec.h"

namespace knead {

// Velocity fields of bodies, and the fields in all: field 0 is of all clay, field c of the clay of
// colour c.
constexpr int most_colours = 4, most_fields = 1 + most_colours;

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
    R per_full[most_fields];  // by colour: 1 / mass of a node in full clay [1/kg]
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

// Contact of all fields at a node, before gravity, tools and walls. mass(c, step): mass of colour c
// at the node `step` from this one [kg]; momentum(c): its momentum here; add(c, impulse) changes
// that. Pairs are taken in order of colour, twice if there are three or more fields. Each pair
// conserves momentum to rounding. Returns whether an impulse was applied.
template <class R, class Mass, class Momentum, class Add>
HD bool separate_fields(const BodyFields<R>& fields, R dx, R dt, Mass&& mass, Momentum&& momentum,
                        Add&& add)
{
    int here = 0;
    ROLLED
    for (int c = 1; c <= fields.colours; ++c) here += mass(c, Int3{}) > 0;
    bool any = false;
    ROLLED
    for (int sweep = here < 2 ? 2 : here > 2 ? 0 : 1; sweep < 2; ++sweep) ROLLED
    for (int a = 1; a < fields.colours; ++a) ROLLED
    for (int b = a + 1; b <= fields.colours; ++b) {
        const R mass_a = mass(a, Int3{}), mass_b = mass(b, Int3{});
        if (!(mass_a > 0 && mass_b > 0)) continue;
        const Gap<R> gap = gap_between<R>([&](int f, Int3 step) {
            return f ? fields.per_full[b] * mass(b, step) : fields.per_full[a] * mass(a, step);
        });
        if (!gap.found) continue;
        const Vec3<R> impulse =
            contact_impulse(Node<R>{momentum(a), mass_a}, Node<R>{momentum(b), mass_b}, gap.n,
                            gap.width * dx / dt, fields.friction);
        if (impulse.x == 0 && impulse.y == 0 && impulse.z == 0) continue;
        add(a, -impulse), add(b, impulse), any = true;
    }
    return any;
}

}  // namespace knead
