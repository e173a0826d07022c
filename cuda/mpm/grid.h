// Grid update: one node's momentum becomes a velocity that obeys gravity, tools and walls.  (3)
#pragma once
#include "cuda/math/node4.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/walls.h"

namespace knead {

// At a place along an axis of which the first `free` nodes are free: 1 on the low wall or behind
// it, -1 on the high one or behind it, else 0. Of the normal that leads away from a wall it is the
// sign.
HD int held_by(int at, int free) { return at < 0 ? 1 : at >= free ? -1 : 0; }
template <class R>
HD Vec3<R> wall_normal(int axis, int sign)
{
    return R(sign) * Vec3<R>{R(axis == 0), R(axis == 1), R(axis == 2)};
}

// What the six walls leave of a velocity at node n.  (18) with fixed, axis-aligned normals
template <class R>
HD Vec3<R> apply_walls(Vec3<R> v, Int3 n, const Walls<R>& walls)
{
    const Int3 at = n - walls.first, free = walls.free;
    if (unsigned(at.x) < unsigned(free.x) && unsigned(at.y) < unsigned(free.y) &&
        unsigned(at.z) < unsigned(free.z))
        return v;
    ROLLED
    for (int axis = 0; axis < 3; ++axis)
        if (const int sign = held_by(component(at, axis), component(free, axis)))
            v = apply_contact(v, wall_normal<R>(axis, sign), {0, 0, 0}, walls.mode, walls.friction);
    return v;
}

// What a face on nodes, of normal `axis`, leaves of the node a step before it and of its image. The
// velocity on the face is their mean, blended with that of the node on it (1): of their mean is
// left what is left of any velocity (18), by the same impulse on both. Where a tool leads the node,
// it leads the image as in a mirror.
template <class R>
HD void apply_face(Node<R>& before, Node<R>& image, Vec3<R> axis, const Walls<R>& walls, bool led)
{
    if (!(before.m > 0 && image.m > 0)) return;
    if (led) {
        const Vec3<R> along = before.p - dot(before.p, axis) * axis;
        image.p = (walls.mode == ContactMode::sticky ? R(0) : R(2)) * along - before.p;
        return;
    }
    const Vec3<R> mean = R(0.5) * (before.p + image.p);
    const Vec3<R> left = apply_contact(mean, axis, {0, 0, 0}, walls.mode, walls.friction);
    const Vec3<R> change = R(2) * (left - mean);
    const R share = image.m / (before.m + image.m);
    before.p = before.p + share * change;
    image.p = image.p + (1 - share) * change;
}

// What the six walls leave of node n and its images, axis by axis; node(k) is the k-th, as a
// reference. `led` by a tool or not.
template <class R, class Each>
HD void apply_walls(Int3 n, Int3 way, const Walls<R>& walls, bool led, Each&& node)
{
    const Int3 at = n - walls.first;
    const int all = image_count(way);
    int next = 1;  // bit of the axis
    ROLLED
    for (int axis = 0; axis < 3; ++axis) {
        const int to_image = component(way, axis);
        const int sign = to_image ? (to_image < 0 ? 1 : -1)
                                  : held_by(component(at, axis), component(walls.free, axis));
        if (!sign) continue;
        const Vec3<R> normal = wall_normal<R>(axis, sign);
        ROLLED
        for (int k = 0; k < all; ++k) {
            Node<R>& one = node(k);
            if (!to_image)
                one.p = apply_contact(one.p, normal, {0, 0, 0}, walls.mode, walls.friction);
            else if (!(k & next))
                apply_face(one, node(k | next), normal, walls, led);
        }
        if (to_image) next *= 2;
    }
}

// A node that is slowed and holds less than this share of a particle's mass is trimmed: nobody sees
// it. With more it is clipped.
constexpr double trimmed_share = 1e-3;

// Velocity of a node that holds mass, before anything stands in its way. Divided each: a weight of
// 1e-33 makes the mass denormal and its reciprocal infinite.
template <class R>
HD Vec3<R> apply_gravity(const Node<R>& node, Vec3<R> gravity, R dt)
{
    return Vec3<R>{node.p.x / node.m, node.p.y / node.m, node.p.z / node.m} + dt * gravity;
}

// The guard: `clipped` is set where a node would outrun one cell per substep, to be counted by the
// caller.
template <class R>
HD Vec3<R> limit_speed(Vec3<R> v, const Lattice<R>& lattice, R dt, bool& clipped)
{
    const R speed = length(v), limit = lattice.dx / dt;
    clipped = speed > limit;
    return clipped ? (limit / speed) * v : v;
}

// All of it for one node; tools(x, v) answers with what the tools near x leave of v.
template <class R, class Tools>
HD Node<R> update(const Node<R>& node, Int3 n, const Lattice<R>& lattice, const Walls<R>& walls,
                  Vec3<R> gravity, R dt, bool& clipped, Tools&& tools)
{
    clipped = false;
    if (!(node.m > 0)) return {{0, 0, 0}, 0};
    const Vec3<R> v = tools(lattice.position(n), apply_gravity(node, gravity, dt));
    return {limit_speed(apply_walls(v, n, walls), lattice, dt, clipped), node.m};
}

template <class R>
HD bool differ(Vec3<R> a, Vec3<R> b)
{
    return a.x != b.x || a.y != b.y || a.z != b.z;
}

// The same for node n and its images, of which node(k) is the k-th: sums that become velocities.
// tools(v) leaves what they leave of n's own, and says whether that is another. Calls slowed(mass)
// for each that is clipped.
template <class R, class Each, class Tools, class Slowed>
HD void update_images(Int3 n, Int3 way, const Lattice<R>& lattice, const Walls<R>& walls,
                      Vec3<R> gravity, R dt, Each&& node, Tools&& tools, Slowed&& slowed)
{
    const int all = image_count(way);
    bool led = false;
    ROLLED
    for (int k = 0; k < all; ++k) {
        Node<R>& one = node(k);
        one = one.m > 0 ? Node<R>{apply_gravity(one, gravity, dt), one.m} : Node<R>{};
        if (k == 0 && one.m > 0) led = tools(one.p);
    }
    apply_walls(n, way, walls, led, node);
    ROLLED
    for (int k = 0; k < all; ++k) {
        bool clipped;
        node(k).p = limit_speed(node(k).p, lattice, dt, clipped);
        if (clipped) slowed(node(k).m);
    }
}

// Which way a number of the nodes rises at node n, at any length: value(node) answers for those
// that are stored, the others hold none.
template <class R, class Value>
HD Vec3<R> slope(const Lattice<R>& lattice, Int3 n, Value&& value)
{
    const auto at = [&](Int3 m) { return lattice.stores(m) ? value(m) : R(0); };
    const auto rise = [&](Int3 axis) { return at(n + axis) - at(n - axis); };
    return {rise({1, 0, 0}), rise({0, 1, 0}), rise({0, 0, 1})};
}

// The tools of a block, strongest last: every tool that holds the node, in order of its index.
template <class R>
HD Vec3<R> apply_tools(const Colliders<R>& c, const Mask& mask, Vec3<R> x, Vec3<R> v)
{
    int tool = -1, at = -1;
    ClosestPoint<R> best{};
    const auto apply = [&] {
        if (at < 0 || best.phi >= 0) return;
        const Tool<R>& t = c.tools[tool];
        const Vec3<R> u = surface_velocity(c, c.primitives[at], best);
        v = apply_contact(v, best.n, u, t.mode, t.friction);
    };
    for_each_candidate(mask, [&](int i) {
        if (!enclosed(c.shapes[i], x)) return;
        if (two_sided(c, i)) return;
        const int owner = c.primitives[i].tool;
        if (owner != tool) apply(), tool = owner, at = -1;
        const ClosestPoint<R> f = closest_point(c.shapes[i], x);
        if (at < 0 || f.phi < best.phi) best = f, at = i;
    });
    apply();
    return v;
}

}  // namespace knead
