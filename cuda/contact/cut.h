// Blades: slabs thinner than the lattice can see, felt from both sides. Clay within reach of a
// blade is labelled with the side it is on; opposite labels no longer share a velocity at a node,
// and keep their labels when the blade has gone, so that a cut lasts.  (23)-(25),
// docs/method/model.md
#pragma once
#include <cstdint>

#include "cuda/contact/contact.h"
#include "cuda/math/node4.h"

namespace knead {

// How far to both sides a blade labels clay, in cells: two stencils of 1.5 cells must not meet
// between labelled and unlabelled clay of opposite sides.
constexpr int blade_reach = 3;

// Within how many cells of a tool a block keeps it among its candidates.
HD float candidate_band(bool blade) { return blade ? float(blade_reach) + 0.5f : 0.5f; }

// Particle::sides
enum Label : std::uint32_t { uncut = 0, above = 1, below = 2 };  // above: where the normal points

HD std::uint32_t opposite(std::uint32_t label) { return label == above ? below : above; }

// A point seen from a blade's sheet.
template <class R>
struct Seen {
    bool covered;  // the sheet, grown by half a cell, lies beside the point
    R h, half;     // signed height over the sheet, half its thickness there [m]
    Vec3<R> n, v;  // the sheet's normal; the velocity of its surface there [m/s]
};

template <class R>
HD Seen<R> seen(const Colliders<R>& c, int primitive, Vec3<R> p, R dx)
{
    const Shape<R>& s = c.shapes[primitive];
    const Primitive& q = c.primitives[primitive];
    const ClosestPoint<R> f = closest_point(s, p);
    const R r =
        f.blend(c.spheres[q.sphere[0]].r, c.spheres[q.sphere[1]].r, c.spheres[q.sphere[2]].r);
    const R h = dot(p - s.c0, s.N), D = f.phi + r;
    const R beside = D * D - h * h;  // in-plane distance to the sheet, squared
    const bool covered =
        beside < R(0.25) * dx * dx && h * h < R(blade_reach * blade_reach) * dx * dx;
    return {covered, h, r, s.N, surface_velocity(c, q, f)};
}

// Calls visit(what p sees, its tool) for every blade of the mask that covers p.
template <class R, class Visit>
HD void for_each_blade(const Colliders<R>& c, const Mask& mask, Vec3<R> p, R dx, Visit&& visit)
{
    for_each_candidate(mask, [&](int i) {
        if (!two_sided(c, i)) return;
        const Seen<R> b = seen(c, i, p, dx);
        if (b.covered) visit(b, c.tools[c.primitives[i].tool]);
    });
}

// What a blade leaves of the velocity that clay with this label has at x: nothing of it enters the
// blade from its side.
template <class R>
HD Vec3<R> sliced(const Colliders<R>& c, const Mask& mask, Vec3<R> x, Vec3<R> v, R dx,
                  std::uint32_t label)
{
    for_each_blade(c, mask, x, dx, [&](const Seen<R>& b, const Tool<R>& tool) {
        const R side = label == below ? R(-1) : R(1);
        if (side * b.h < b.half)
            v = apply_contact(v, side * b.n, b.v, ContactMode::separate, tool.friction);
    });
    return v;
}

// Clay of two labels at one node: they may part, and slide with friction, but not pass through each
// other. `mine` is this label's velocity, `shared` that of both together, n points out of mine.
// Both sides use the same shared velocity, so their momenta add up to what they were.  (25)
template <class R>
HD Vec3<R> kept_apart(Vec3<R> mine, Vec3<R> shared, Vec3<R> n, R friction)
{
    return apply_contact(mine, -n, shared, ContactMode::separate, friction);
}

constexpr float cut_friction = 0.3f;  // Coulomb, between the faces of a cut [1]

// Keeps the velocities of the two labels apart at a node; `down` points, at any length, from what
// lies above to what lies below.
template <class R>
HD void part(Vec3<R>& v_above, Vec3<R>& v_below, Vec3<R> shared, Vec3<R> down)
{
    const R size = length(down);
    if (!(size > 0)) return;
    const Vec3<R> n = (1 / size) * down;
    v_above = kept_apart(v_above, shared, n, R(cut_friction));
    v_below = kept_apart(v_below, shared, -n, R(cut_friction));
}

// How much of a node's mass may be uncut clay before it holds the two sides of a cut together [1].
constexpr float bridge = 1e-3f;

// The velocities of a node's three fields: of all clay, and of each label with the uncut clay.
// Where uncut clay is left, as before a blade's edge, all three are one: else uncut and labelled
// clay of the same place would be strained differently, and their pressures, cancelling each other
// at the nodes, would grow without end. `down()` answers as for part().  (25)
template <class R, class Down>
HD void divide(Node<R> (&v)[3], const R (&mass)[3], Down&& down)
{
    if (mass[above] + mass[below] - mass[0] > R(bridge) * mass[0])
        v[above].p = v[below].p = v[0].p;
    else if (mass[above] < mass[0] && mass[below] < mass[0])
        part(v[above].p, v[below].p, v[0].p, down());
}

}  // namespace knead
