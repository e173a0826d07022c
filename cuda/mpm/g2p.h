// Grid to particle: gathers velocity and its gradient; updates position and strain.  (8), (9)
#pragma once
#include "cuda/math/node4.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/stencil.h"

namespace knead {

// Weighted sum of three values along an axis, accumulated one at a time.
template <int at, class R, class V>
HD void blend(V& sum, R w, const V& value)
{
    sum = at == 0 ? w * value : sum + w * value;
}
// The same with its moment about the middle value, in steps. Before the third value, `slope` is the
// weighted first one.
template <int at, class R, class V>
HD void blend(V& sum, V& slope, R w, const V& value)
{
    if (at == 0) slope = w * value;
    if (at == 2) slope = w * value - slope;
    blend<at>(sum, w, value);
}

// Sums over a plane of nodes of equal x: of w v, and of w v times the step from the middle node.
template <class V>
struct Plane {
    V v, by_y, by_z;
};
template <int i, class R, class Velocity>
HD auto plane(const Stencil<R>& s, Velocity&& velocity)
{
    using V = decltype(velocity(Int3{}));
    Plane<V> sum;
    const auto column = [&]<int j>(std::integral_constant<int, j>) {
        V v, slope;
        blend<0>(v, slope, s.w[0].z, velocity(Int3{i, j, 0}));
        blend<1>(v, slope, s.w[1].z, velocity(Int3{i, j, 1}));
        blend<2>(v, slope, s.w[2].z, velocity(Int3{i, j, 2}));
        blend<j>(sum.v, sum.by_y, s.w[j].y, v);
        blend<j>(sum.by_z, s.w[j].y, slope);
    };
    column(std::integral_constant<int, 0>{});
    column(std::integral_constant<int, 1>{});
    column(std::integral_constant<int, 2>{});
    return sum;
}

// velocity(step) accesses the memory: it returns a Vec3, or a whole node as a Four; then the sum
// has mass_around(). The sums are factorised: along z, then y, then x.
template <class R, class Velocity>
HD auto gather(Particle<R>& q, const Stencil<R>& s, std::type_identity_t<const Spacing<R>&> spacing,
               Velocity&& velocity)
{
    using V = decltype(velocity(Int3{}));
    V v, by_x, by_y, by_z;
    const auto add = [&]<int i>(std::integral_constant<int, i>) {
        const Plane<V> p = plane<i>(s, velocity);
        blend<i>(v, by_x, s.w[i].x, p.v);
        blend<i>(by_y, s.w[i].x, p.by_y);
        blend<i>(by_z, s.w[i].x, p.by_z);
    };
    add(std::integral_constant<int, 0>{});
    add(std::integral_constant<int, 1>{});
    add(std::integral_constant<int, 2>{});
    const R dx = spacing.dx, scale = spacing.per_D;
    const Vec3<R> d = scale * (s.d + Vec3<R>{dx, dx, dx});  // to the middle node
    const R step = scale * dx;
    q.v = first_three(v);
    q.C = {d.x * q.v + step * first_three(by_x), d.y * q.v + step * first_three(by_y),
           d.z * q.v + step * first_three(by_z)};
    return v;
}

// Velocity at x, of the nodes around it that hold mass; `otherwise` if none does. node(i) returns a
// Node.
template <class R, class NodeAt>
HD Vec3<R> velocity_at(Vec3<R> x, std::type_identity_t<const Spacing<R>&> spacing,
                       Vec3<R> otherwise, NodeAt&& node)
{
    const Stencil<R> s = stencil(x, spacing);
    Vec3<R> sum{};
    R share = 0;
    for_each_node(s, spacing.dx, [&](Int3 step, R w, Vec3<R>) {
        const Node<R> n = node(s.base + step);
        if (n.m > 0) sum = sum + w * n.p, share += w;
    });
    return share > 0 ? (1 / share) * sum : otherwise;
}

// From a stencil's base to the node nearest to the particle.
constexpr Int3 nearest_node = {1, 1, 1};

// Mass per cell at the particle [kg], from the sum that gather() or gather_rows() returns; divided
// by the particle's mass, the number of particles per cell.  (19)
template <class R>
HD R mass_around(const Four<R>& sum)
{
    return last(sum);
}

// Damping of an isolated particle: if the nearest node has less than one particle per cell, the
// rate of strain is reduced, down to about a fifth, so that oscillations do not grow. Spin is
// unchanged, and with one particle per cell or more the rate of strain is, too.  (8)
template <class R>
HD void damp_isolated_particle(Mat3<R>& C, R per_cell)
{
    const R missing = R(5) * max(R(0), R(1) - per_cell);
    C = C - missing / (R(1) + missing) * full(symmetric(C));
}

// Whether the velocity gradient deforms a particle's surroundings too much for one substep.
template <class R>
HD bool abrupt(const Mat3<R>& C, R dt)
{
    const R squares = dot(C.a, C.a) + dot(C.b, C.b) + dot(C.c, C.c);
    return dt * dt * squares > R(0.35) * R(0.35);
}

// The same sums row by row: of w v, and of w v times the step from the base along x, y and z.
template <class R>
struct Gathered {
    Four<R> v, by_x, by_y, by_z;
};

// rows(j, k) returns the velocities of the three nodes at steps j and k along y and z from the
// base, side by side in registers; node_of<n>(row) extracts one. tests/solver/lanes_test.cpp
// compares this form with gather().
template <class R, class Rows>
HD Gathered<R> gather_rows(const Stencil<R>& s, Rows&& rows)
{
    using V = decltype(rows(0, 0));
    V sum{}, sum_y{}, sum_z{};
    UNROLL
    for (int k = 0; k < 3; ++k) {
        const V second = s.w[1].y * rows(1, k), third = s.w[2].y * rows(2, k);
        const V plane = s.w[0].y * rows(0, k) + second + third;
        sum = sum + s.w[k].z * plane;
        sum_y = sum_y + s.w[k].z * (second + R(2) * third);
        if (k) sum_z = sum_z + (R(k) * s.w[k].z) * plane;
    }
    const V w = weights_along_x(s);
    const auto total = [](const V& a) { return node_of<0>(a) + node_of<1>(a) + node_of<2>(a); };
    sum = w * sum;
    return {total(sum), node_of<1>(sum) + R(2) * node_of<2>(sum), total(w * sum_y),
            total(w * sum_z)};
}

// The velocity gradient from those sums; d is the offset from the particle to the base node [m]. R
// may hold the values of many particles.
template <class R>
HD Mat3<R> velocity_gradient(Vec3<R> v, const Mat3<R>& by_step, Vec3<R> d,
                             std::type_identity_t<const Spacing<R>&> spacing)
{
    const R dx = spacing.dx, scale = spacing.per_D;
    return {scale * (d.x * v + dx * by_step.a), scale * (d.y * v + dx * by_step.b),
            scale * (d.z * v + dx * by_step.c)};
}

// b <- (I + dt C) b (I + dt C)^T, written for e = b - I so that small strains stay exact: e + L e +
// L =: U, then the six components of U + U L^T + L^T.  (9)
template <class R>
HD Sym3<R> advance_b(const Sym3<R>& e, const Mat3<R>& C, R dt)
{
    const Mat3<R> L = dt * C, E = full(e), U = E + L * E + L, rows = transpose(L);
    const auto at = [](R u, Vec3<R> row_u, Vec3<R> row_l, R l) {
        return u + dot(row_u, row_l) + l;
    };
    const Mat3<R> V = transpose(U);  // columns are the rows of U
    return {at(U.a.x, V.a, rows.a, L.a.x), at(U.b.y, V.b, rows.b, L.b.y),
            at(U.c.z, V.c, rows.c, L.c.z), at(U.b.x, V.a, rows.b, L.a.y),
            at(U.c.x, V.a, rows.c, L.a.z), at(U.c.y, V.b, rows.c, L.b.z)};
}

}  // namespace knead
