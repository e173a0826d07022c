// Blades: slabs thinner than the lattice resolves, with contact on both sides. Clay within reach of
// a blade is labelled with its side; opposite labels do not share a velocity at a node, and labels
// persist when the blade has gone, so that a cut lasts.  (23)-(25), docs/method/model.md
#pragma once
#include <cstdint>

#include "cuda/contact/contact.h"
#include "cuda/math/node4.h"

namespace knead {

// Distance from a blade up to which clay is labelled, on both sides [cells]: the stencils, of 1.5
// cells, of unlabelled clay and of clay with the opposite label must not overlap.
constexpr int blade_reach = 3;

// Distance from a tool within which it is a candidate of a block [cells].
HD float candidate_band(bool blade) { return blade ? float(blade_reach) + 0.5f : 0.5f; }

// bits of Particle::sides
enum Label : std::uint32_t { uncut = 0, above = 1, below = 2 };  // above: where the normal points

HD std::uint32_t opposite(std::uint32_t label) { return label == above ? below : above; }

// Position of a point relative to a blade's sheet.
template <class R>
struct Seen {
    bool covered;  // the point projects onto the sheet, grown by half a cell, within blade_reach
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

// Calls visit(seen, tool) for every blade of the mask that covers p.
template <class R, class Visit>
HD void for_each_blade(const Colliders<R>& c, const Mask& mask, Vec3<R> p, R dx, Visit&& visit)
{
    for_each_candidate(mask, [&](int i) {
        if (!two_sided(c, i)) return;
        const Seen<R> b = seen(c, i, p, dx);
        if (b.covered) visit(b, c.tools[c.primitives[i].tool]);
    });
}

// Applies blades to the velocity at x of clay with this label: it does not enter a blade from its
// side.
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

// Contact of two labels at one node: they may separate, and slide with friction, but not
// interpenetrate. `mine`: velocity of this label; `shared`: common velocity of both labels; n:
// normal out of this label's clay. Both sides use the same shared velocity, so total momentum is
// conserved.  (25)
template <class R>
HD Vec3<R> kept_apart(Vec3<R> mine, Vec3<R> shared, Vec3<R> n, R friction)
{
    return apply_contact(mine, -n, shared, ContactMode::separate, friction);
}

constexpr float cut_friction = 0.3f;  // Coulomb, between the faces of a cut [1]

// Separates the velocities of the two labels at a node; `down` points from the upper to the lower
// clay, not normalised.
template <class R>
HD void part(Vec3<R>& v_above, Vec3<R>& v_below, Vec3<R> shared, Vec3<R> down)
{
    const R size = length(down);
    if (!(size > 0)) return;
    const Vec3<R> n = (1 / size) * down;
    v_above = kept_apart(v_above, shared, n, R(cut_friction));
    v_below = kept_apart(v_below, shared, -n, R(cut_friction));
}

// Share of uncut clay in a node's mass above which it holds the two sides of a cut together [1].
constexpr float bridge = 1e-3f;

// The velocities of a node's three fields: of all clay, and of each label with the uncut clay. If
// uncut clay is left, as ahead of a blade's edge, all three are equal: else uncut and labelled clay
// at the same place would strain differently, and their pressures, which cancel at the nodes, would
// grow without bound. down() returns `down` of part().  (25)
template <class R, class Down>
HD void divide(Node<R> (&v)[3], const R (&mass)[3], Down&& down)
{
    if (mass[above] + mass[below] - mass[0] > R(bridge) * mass[0])
        v[above].p = v[below].p = v[0].p;
    else if (mass[above] < mass[0] && mass[below] < mass[0])
        part(v[above].p, v[below].p, v[0].p, down());
}

}  // namespace knead
