// Grid update: one node's momentum becomes a velocity that obeys gravity, tools and walls.  (3)
#pragma once
#include "cuda/math/node4.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/sliding.h"
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

// The sign along each axis of the walls that node n is on or behind.
template <class R>
HD Int3 walls_holding(Int3 n, const Walls<R>& walls)
{
    const Int3 at = n - walls.first, free = walls.free;
    return {held_by(at.x, free.x), held_by(at.y, free.y), held_by(at.z, free.z)};
}
// The axis of the wall that a node meets, or -1 unless it meets one alone.
HD int lone_wall(Int3 met)
{
    const bool alone = (met.x != 0) + (met.y != 0) + (met.z != 0) == 1;
    return !alone ? -1 : met.x ? 0 : met.y ? 1 : 2;
}
// Where a node that meets these walls keeps how it slides: nowhere, unless it meets one alone.
template <class R>
HD int sliding_place(Int3 n, Int3 met, const Walls<R>& walls, Int3 size)
{
    const int axis = lone_wall(met);
    return axis < 0 ? -1 : sliding_place(n, axis, component(met, axis), walls, size);
}

// How far clay is from a face on nodes [cells], by the masses of the node on the face and of the
// node a step before it: under flush clay the first has 0.51 of the second, under clay that hangs
// `g` cells higher 0.7 g less. Clay nearer than a tenth of a cell touches.  (18b)
template <class R>
HD R gap_before_face(R mass_on_face, R mass_before)
{
    return mass_before > 0 ? max(R(0), (R(0.44) - mass_on_face / mass_before) / R(0.7)) : R(0);
}

// Masses that nobody knows: no clay is seen to hang above a face.
template <class R>
struct UnknownMasses {
    HD R operator()(Int3) const { return 0; }
};

// How fast clay at node n may still approach a wall that it meets [m/s]: as far as the gap in this
// substep. `paired`: n is the node before a face on nodes, with its image. masses(m) is the
// mass of all clay at node m.  (18b)
template <class R, class Masses>
HD R approach_speed(Int3 n, int axis, int sign, bool paired, const Walls<R>& walls, R dx, R dt,
                    Masses&& masses)
{
    const int at = component(n, axis);
    const int face = component(sign > 0 ? walls.low_face : walls.high_face, axis);
    if (at != face + (paired ? sign : 0)) return 0;  // behind a face, or it stands on no node
    const int step = paired ? -sign : sign;
    const R own = masses(n),
            other =
                masses(n + Int3{axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0});
    return (dx / dt) * (paired ? gap_before_face(other, own) : gap_before_face(own, other));
}

// What the six walls leave of a velocity at node n of so much mass [kg]; masses(m) is that of node
// m.  (18), (18a), (18b) with fixed, axis-aligned normals
template <class R, class Slides = Forgotten<R>, class Masses = UnknownMasses<R>>
HD Vec3<R> apply_walls(Vec3<R> v, Int3 n, const Lattice<R>& lattice, const Walls<R>& walls,
                       R mass = 0, R dt = 1, const Slides& slides = {}, Masses&& masses = {})
{
    const Int3 at = n - walls.first, free = walls.free;
    if (unsigned(at.x) < unsigned(free.x) && unsigned(at.y) < unsigned(free.y) &&
        unsigned(at.z) < unsigned(free.z))
        return v;
    const Int3 met = walls_holding(n, walls);
    const int place = sliding_place(n, met, walls, lattice.size);
    ROLLED
    for (int axis = 0; axis < 3; ++axis)
        if (const int sign = component(met, axis)) {
            const R approach = approach_speed(n, axis, sign, false, walls, lattice.dx, dt, masses);
            v = apply_friction(v, wall_normal<R>(axis, sign), approach, walls, mass, dt, place,
                               slides);
        }
    return v;
}

// What a wall of that normal leaves of a node that is on it or behind it; or, `paired`, what a face
// on nodes leaves of the node a step before it and of its image. The velocity on the face is their
// mean, blended with that of the node on it (1): of their mean is left what is left of any velocity
// (18), by the same impulse on both. Where a tool leads the node, it leads the image as in a
// mirror. `approach`, `place` and `slides`: see sliding.h.
template <class R, class Slides = Forgotten<R>>
HD void apply_wall(Node<R>& node, Node<R>& mirror_node, bool paired, Vec3<R> normal,
                   const Walls<R>& walls, bool led, R approach = 0, R dt = 1, int place = -1,
                   const Slides& slides = {})
{
    if (paired && !(node.m > 0 && mirror_node.m > 0)) return;
    if (!paired) {
        node.p = apply_friction(node.p, normal, approach, walls, node.m, dt, place, slides);
        return;
    }
    const Vec3<R> mean = R(0.5) * (node.p + mirror_node.p);
    if (led) {
        if (approach > 0 && dot(mean, normal) >= -approach) return;
        const Vec3<R> along = node.p - dot(node.p, normal) * normal;
        mirror_node.p = (walls.mode == ContactMode::sticky ? R(0) : R(2)) * along - node.p -
                        R(2) * approach * normal;
        return;
    }
    const R share = mirror_node.m / (node.m + mirror_node.m);
    const Vec3<R> left =
        apply_friction(mean, normal, approach, walls, R(4) * share * node.m, dt, place, slides);
    const Vec3<R> change = R(2) * (left - mean);
    node.p = node.p + share * change;
    mirror_node.p = mirror_node.p + (1 - share) * change;
}

// Nodes in an array.
template <class R>
struct InArray {
    Node<R>* nodes;
    HD Node<R> get(int k) const { return nodes[k]; }
    HD void put(int k, const Node<R>& node) const { nodes[k] = node; }
};

// Of the walls that node n meets with its images, `way` to them, the sign along each axis as
// held_by() has it.
template <class R>
HD Int3 walls_met(Int3 n, Int3 mirror_offset, const Walls<R>& walls)
{
    const Int3 at = n - walls.first, free = walls.free;
    const auto side = [](int to_image, int place, int count) {
        return to_image ? (to_image < 0 ? 1 : -1) : held_by(place, count);
    };
    return {side(mirror_offset.x, at.x, free.x), side(mirror_offset.y, at.y, free.y),
            side(mirror_offset.z, at.z, free.z)};
}

// What the walls met leave of node n and its images, axis by axis; get(k) and put(k, node) read and
// write the k-th. `led` by a tool or not; masses(m) is the mass of all clay at node m.
template <class R, class Nodes, class Masses>
HD void apply_walls(Int3 n, Int3 met, Int3 mirror_offset, const Lattice<R>& lattice,
                    const Walls<R>& walls, bool led, R dt, Nodes&& nodes, Masses&& masses)
{
    const int all = mirror_count(mirror_offset);
    int next = 1;  // bit of the axis
    ROLLED
    for (int axis = 0; axis < 3; ++axis) {
        const int sign = component(met, axis);
        if (!sign) continue;
        const bool paired = component(mirror_offset, axis) != 0;
        const Vec3<R> normal = wall_normal<R>(axis, sign);
        const int other = paired ? next : 0;
        const R approach = approach_speed(n, axis, sign, paired, walls, lattice.dx, dt, masses);
        ROLLED
        for (int k = 0; k < all; k = ((k | other) + 1) & ~other) {  // those without the bit
            Node<R> node = nodes.get(k), mirrored{};
            if (paired) mirrored = nodes.get(k | other);
            apply_wall(node, mirrored, paired, normal, walls, led, approach);
            nodes.put(k, node);
            if (paired) nodes.put(k | other, mirrored);
        }
        next += other;
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
    const R limit = lattice.dx / dt, square = dot(v, v);
    clipped = false;
    if (square < R(0.99) * limit * limit) return v;  // most are: no root is taken
    const R speed = std::sqrt(square);
    clipped = speed > limit;
    return clipped ? (limit / speed) * v : v;
}

// All of it for one node; tools(x, v) answers with what the tools near x leave of v; `slides`: see
// sliding.h.
template <class R, class Tools, class Slides = Forgotten<R>, class Masses = UnknownMasses<R>>
HD Node<R> update(const Node<R>& node, Int3 n, const Lattice<R>& lattice, const Walls<R>& walls,
                  Vec3<R> gravity, R dt, bool& clipped, Tools&& tools, const Slides& slides = {},
                  Masses&& masses = {})
{
    clipped = false;
    if (!(node.m > 0)) return {{0, 0, 0}, 0};
    const Vec3<R> v = tools(lattice.position(n), apply_gravity(node, gravity, dt));
    const Vec3<R> left = apply_walls(v, n, lattice, walls, node.m, dt, slides, masses);
    return {limit_speed(left, lattice, dt, clipped), node.m};
}

template <class R>
HD bool differ(Vec3<R> a, Vec3<R> b)
{
    return a.x != b.x || a.y != b.y || a.z != b.z;
}

// A node's velocity after gravity, alone.
template <class R>
HD Node<R> after_gravity(const Node<R>& sum, Vec3<R> gravity, R dt)
{
    return sum.m > 0 ? Node<R>{apply_gravity(sum, gravity, dt), sum.m} : Node<R>{};
}

// The same for node n and its images, sums that become velocities, as apply_walls() takes them. The
// node's own is v after gravity and tools; `led` if these left another. Calls slowed(mass) for each
// that is clipped; masses(m) is the mass of all clay at node m, whichever field this is.
template <class R, class Nodes, class Slowed, class Slides, class Masses>
HD void update_led(Int3 n, Int3 mirror_offset, const Lattice<R>& lattice, const Walls<R>& walls,
                   Vec3<R> gravity, R dt, Nodes&& nodes, Vec3<R> v, bool led, Slowed&& slowed,
                   const Slides& slides, Masses&& masses)
{
    const Int3 met = walls_met(n, mirror_offset, walls);
    const int all = mirror_count(mirror_offset);
    if (const int axis = lone_wall(met); axis >= 0) {  // most often: in registers
        const int sign = component(met, axis);
        const int place = sliding_place(n, axis, sign, walls, lattice.size);
        const bool paired = all > 1;
        Node<R> own{v, nodes.get(0).m}, mirror_node{};
        if (paired) mirror_node = after_gravity(nodes.get(1), gravity, dt);
        const R approach = approach_speed(n, axis, sign, paired, walls, lattice.dx, dt, masses);
        apply_wall(own, mirror_node, paired, wall_normal<R>(axis, sign), walls, led, approach, dt,
                   place, slides);
        if (paired) nodes.put(1, mirror_node);
        nodes.put(0, own);
    } else {
        nodes.put(0, {v, nodes.get(0).m});
        ROLLED
        for (int k = 1; k < all; ++k) nodes.put(k, after_gravity(nodes.get(k), gravity, dt));
        apply_walls(n, met, mirror_offset, lattice, walls, led, dt, nodes, masses);
    }
    ROLLED
    for (int k = 0; k < all; ++k) {
        Node<R> node = nodes.get(k);
        bool clipped;
        node.p = limit_speed(node.p, lattice, dt, clipped);
        nodes.put(k, node);
        if (clipped) slowed(node.m);
    }
}

// The same where tools(v) leaves what they leave of the node's velocity, and says whether that is
// another.
template <class R, class Nodes, class Tools, class Slowed, class Slides, class Masses>
HD void update_mirrors(Int3 n, Int3 mirror_offset, const Lattice<R>& lattice, const Walls<R>& walls,
                       Vec3<R> gravity, R dt, Nodes&& nodes, Tools&& tools, Slowed&& slowed,
                       const Slides& slides, Masses&& masses)
{
    const Node<R> own = nodes.get(0);
    Vec3<R> v{};
    bool led = false;
    if (own.m > 0) v = apply_gravity(own, gravity, dt), led = tools(v);
    update_led(n, mirror_offset, lattice, walls, gravity, dt, nodes, v, led, slowed, slides,
               masses);
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
