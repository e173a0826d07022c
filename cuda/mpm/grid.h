// Grid update: computes the velocity of a node from its momentum, under gravity, tools and walls.
// (3)
#pragma once
#include "cuda/math/node4.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/sliding.h"
#include "cuda/mpm/walls.h"

namespace knead {

// Sign of the wall normal (away from the wall) at index `at` along an axis whose first `free` nodes
// are free: 1 on or behind the low wall, -1 on or behind the high one, else 0.
HD int held_by(int at, int free) { return at < 0 ? 1 : at >= free ? -1 : 0; }
template <class R>
HD Vec3<R> wall_normal(int axis, int sign)
{
    return R(sign) * Vec3<R>{R(axis == 0), R(axis == 1), R(axis == 2)};
}

// The normal signs of the walls that node n is on or behind, by axis.
template <class R>
HD Int3 walls_holding(Int3 n, const Walls<R>& walls)
{
    const Int3 at = n - walls.first, free = walls.free;
    return {held_by(at.x, free.x), held_by(at.y, free.y), held_by(at.z, free.z)};
}
// The axis of the wall that a node meets; -1 unless it meets exactly one.
HD int lone_wall(Int3 met)
{
    const bool alone = (met.x != 0) + (met.y != 0) + (met.z != 0) == 1;
    return !alone ? -1 : met.x ? 0 : met.y ? 1 : 2;
}
// Index of the Sliding record of node n; -1 unless it meets exactly one wall.
template <class R>
HD int sliding_place(Int3 n, Int3 met, const Walls<R>& walls, Int3 size)
{
    const int axis = lone_wall(met);
    return axis < 0 ? -1 : sliding_place(n, axis, component(met, axis), walls, size);
}

// Gap between clay and a face that lies on nodes [cells], from the masses of the node on the face
// and of the node before it. Their ratio is 0.51 for clay flush with the face and 0.7 g less at a
// gap of g cells. A gap below a tenth of a cell counts as contact.  (18b)
template <class R>
HD R gap_before_face(R mass_on_face, R mass_before)
{
    return mass_before > 0 ? max(R(0), (R(0.44) - mass_on_face / mass_before) / R(0.7)) : R(0);
}

// For masses that are not available: the gap is always 0.
template <class R>
struct UnknownMasses {
    HD R operator()(Int3) const { return 0; }
};

// The speed at which clay at node n may still approach a wall that it meets [m/s]: it closes the
// gap in this substep. `paired`: n is the node before a face on nodes, updated with its mirror
// node. masses(m) returns the mass of all clay at node m.  (18b)
template <class R, class Masses>
HD R approach_speed(Int3 n, int axis, int sign, bool paired, const Walls<R>& walls, R dx, R dt,
                    Masses&& masses)
{
    const int at = component(n, axis);
    const int face = component(sign > 0 ? walls.low_face : walls.high_face, axis);
    if (at != face + (paired ? sign : 0)) return 0;  // behind a face, or it is between nodes
    const int step = paired ? -sign : sign;
    const R own = masses(n),
            other =
                masses(n + Int3{axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0});
    return (dx / dt) * (paired ? gap_before_face(other, own) : gap_before_face(own, other));
}

// Applies the six walls to the velocity of node n, of mass `mass` [kg]. masses(m) returns the mass
// of node m.  (18), (18a), (18b) with fixed, axis-aligned normals
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

// Applies one wall to a node on or behind it; if `paired`, to the node one step before a face on
// nodes and to its mirror node. The velocity at the face is the mean of the two velocities blended
// with the velocity of the node on the face (1), so (18) is applied to the mean, with the same
// impulse on both. If a tool leads the node, its mirror node gets the mirrored velocity.
// `approach`, `place` and `slides`: see sliding.h.
template <class R, class Slides = Forgotten<R>>
HD void apply_wall(Node<R>& node, Node<R>& mirror_node, bool paired, Vec3<R> normal,
                   const Walls<R>& walls, bool by_tool, R approach = 0, R dt = 1, int place = -1,
                   const Slides& slides = {})
{
    if (paired && !(node.m > 0 && mirror_node.m > 0)) return;
    if (!paired) {
        node.p = apply_friction(node.p, normal, approach, walls, node.m, dt, place, slides);
        return;
    }
    const Vec3<R> mean = R(0.5) * (node.p + mirror_node.p);
    if (by_tool) {
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

// The walls that node n meets together with its mirror nodes at `mirror_offset`: normal sign along
// each axis, as held_by().
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

// Applies the walls met to node n and its mirror nodes, axis by axis. get(k) and put(k, node)
// access the k-th node. `by_tool`: a tool changed the velocity. masses(m) returns the mass of all
// clay at node m.
template <class R, class Nodes, class Masses>
HD void apply_walls(Int3 n, Int3 met, Int3 mirror_offset, const Lattice<R>& lattice,
                    const Walls<R>& walls, bool by_tool, R dt, Nodes&& nodes, Masses&& masses)
{
    const int all = mirror_count(mirror_offset);
    int next = 1;  // bit of this axis in k
    ROLLED
    for (int axis = 0; axis < 3; ++axis) {
        const int sign = component(met, axis);
        if (!sign) continue;
        const bool paired = component(mirror_offset, axis) != 0;
        const Vec3<R> normal = wall_normal<R>(axis, sign);
        const int other = paired ? next : 0;
        const R approach = approach_speed(n, axis, sign, paired, walls, lattice.dx, dt, masses);
        ROLLED
        for (int k = 0; k < all; k = ((k | other) + 1) & ~other) {  // all k without this bit
            Node<R> node = nodes.get(k), mirrored{};
            if (paired) mirrored = nodes.get(k | other);
            apply_wall(node, mirrored, paired, normal, walls, by_tool, approach);
            nodes.put(k, node);
            if (paired) nodes.put(k | other, mirrored);
        }
        next += other;
    }
}

// Speed-limited nodes below this fraction of a particle's mass are counted as negligible instead of
// clipped: the effect is invisible.
constexpr double trimmed_share = 1e-3;

// Velocity of a node with mass, before contact. Each component is divided: a weight of 1e-33 makes
// the mass denormal and its reciprocal infinite.
template <class R>
HD Vec3<R> apply_gravity(const Node<R>& node, Vec3<R> gravity, R dt)
{
    return Vec3<R>{node.p.x / node.m, node.p.y / node.m, node.p.z / node.m} + dt * gravity;
}

// Speed limit of one cell per substep. Sets `clipped` if the velocity was reduced; the caller
// counts these nodes.
template <class R>
HD Vec3<R> limit_speed(Vec3<R> v, const Lattice<R>& lattice, R dt, bool& clipped)
{
    const R limit = lattice.dx / dt, square = dot(v, v);
    clipped = false;
    if (square < R(0.99) * limit * limit) return v;  // most nodes: no square root
    const R speed = std::sqrt(square);
    clipped = speed > limit;
    return clipped ? (limit / speed) * v : v;
}

// The whole update of one node. tools(x, v) returns v after the tools near x; `slides`: see
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

// Velocity of a node after gravity only.
template <class R>
HD Node<R> after_gravity(const Node<R>& sum, Vec3<R> gravity, R dt)
{
    return sum.m > 0 ? Node<R>{apply_gravity(sum, gravity, dt), sum.m} : Node<R>{};
}

// The update of node n and its mirror nodes, accessed as in apply_walls(); sums become velocities.
// v is the node's velocity after gravity and tools; `by_tool` if tools changed it. Calls
// slowed(mass) for each clipped node. masses(m) returns the mass of all clay at node m in every
// field.
template <class R, class Nodes, class Slowed, class Slides, class Masses>
HD void update_after_tools(Int3 n, Int3 mirror_offset, const Lattice<R>& lattice,
                           const Walls<R>& walls, Vec3<R> gravity, R dt, Nodes&& nodes, Vec3<R> v,
                           bool by_tool, Slowed&& slowed, const Slides& slides, Masses&& masses)
{
    const Int3 met = walls_met(n, mirror_offset, walls);
    const int all = mirror_count(mirror_offset);
    if (const int axis = lone_wall(met); axis >= 0) {  // most nodes: all in registers
        const int sign = component(met, axis);
        const int place = sliding_place(n, axis, sign, walls, lattice.size);
        const bool paired = all > 1;
        Node<R> own{v, nodes.get(0).m}, mirror_node{};
        if (paired) mirror_node = after_gravity(nodes.get(1), gravity, dt);
        const R approach = approach_speed(n, axis, sign, paired, walls, lattice.dx, dt, masses);
        apply_wall(own, mirror_node, paired, wall_normal<R>(axis, sign), walls, by_tool, approach,
                   dt, place, slides);
        if (paired) nodes.put(1, mirror_node);
        nodes.put(0, own);
    } else {
        nodes.put(0, {v, nodes.get(0).m});
        ROLLED
        for (int k = 1; k < all; ++k) nodes.put(k, after_gravity(nodes.get(k), gravity, dt));
        apply_walls(n, met, mirror_offset, lattice, walls, by_tool, dt, nodes, masses);
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

// The same, where tools(v) applies the tools to v and returns whether they changed it.
template <class R, class Nodes, class Tools, class Slowed, class Slides, class Masses>
HD void update_mirrors(Int3 n, Int3 mirror_offset, const Lattice<R>& lattice, const Walls<R>& walls,
                       Vec3<R> gravity, R dt, Nodes&& nodes, Tools&& tools, Slowed&& slowed,
                       const Slides& slides, Masses&& masses)
{
    const Node<R> own = nodes.get(0);
    Vec3<R> v{};
    bool by_tool = false;
    if (own.m > 0) v = apply_gravity(own, gravity, dt), by_tool = tools(v);
    update_after_tools(n, mirror_offset, lattice, walls, gravity, dt, nodes, v, by_tool, slowed,
                       slides, masses);
}

// Direction of the gradient at node n of a nodal value, not normalised. value(node) is called for
// stored nodes only; the others count as 0.
template <class R, class Value>
HD Vec3<R> slope(const Lattice<R>& lattice, Int3 n, Value&& value)
{
    const auto at = [&](Int3 m) { return lattice.stores(m) ? value(m) : R(0); };
    const auto rise = [&](Int3 axis) { return at(n + axis) - at(n - axis); };
    return {rise({1, 0, 0}), rise({0, 1, 0}), rise({0, 0, 1})};
}

// Applies the tools of a block in order of index; the last one that contains the node takes
// precedence.
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
