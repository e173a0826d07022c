// How a Gaussian follows the clay around it: it goes with the lattice's velocity, and stretches and
// turns by that velocity's gradient. A fit to the nodes that hold clay, because a photographed
// surface is where half of them hold none.  (31)-(34)
#pragma once
#include "cuda/math/rotation.h"
#include "cuda/mpm/edit.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/project.h"
#include "cuda/mpm/stencil.h"

namespace knead {

// The centre of a splat, and what has become of its neighbourhood since it was attached.
template <class R>
struct Gaussian {
    Vec3<R> x;   // [m]
    Mat3<R> F;   // total deformation gradient: no return map takes the flow out of it, or splats
                 // would keep their size while clay spreads, and holes open between them [1]
    int object;  // whose clay it follows
    std::uint32_t sides;  // which side of a cut, and whether it is held: as Particle::sides
    HD bool still() const { return (sides & Particle<R>::still_bit) != 0; }
    HD std::uint32_t label() const { return sides & ~Particle<R>::still_bit; }
    HD void hold(bool held) { sides = label() | (held ? Particle<R>::still_bit : 0); }
};

// Some of many Gaussians change, and some are new. One that is split goes so far to one side, its
// second to the other; the new ones lie beside particles, whose object and label they take, or
// where they are told to.
struct GaussianSplit {
    int index;
    Vec3<double> way;  // [m]
};
struct GaussianBeside {
    int particle;      // id
    Vec3<double> way;  // from it [m]
};
struct GaussianPlace {  // of an undeformed one
    Vec3<float> x;      // [m]
    int object;
};

// Undeformed, at x.
template <class R>
HD Gaussian<R> gaussian_at(Vec3<R> x, int object)
{
    return {x, diagonal(R(1)), object, uncut};
}

template <class To, class From>
HD Gaussian<To> cast(const Gaussian<From>& g)
{
    return {cast<To>(g.x), {cast<To>(g.F.a), cast<To>(g.F.b), cast<To>(g.F.c)}, g.object, g.sides};
}

// What a node that holds the mass m counts for, where the lightest particle has the mass
// 1 / per_mass: less than 1 where it holds less than that. The velocity of such a node is that of
// whatever little reaches it, and may be anything.  (31)
template <class R>
HD R share(R m, R per_mass)
{
    return min(per_mass * m, R(1));
}

// A node's velocity and what it counts for.
template <class R>
struct NodeShare {
    Vec3<R> v;  // [m/s]
    R h;        // share() [1]
};
template <class R>
HD NodeShare<R> node_share(const Node<R>& n, R per_mass)
{
    return {n.p, share(n.m, per_mass)};
}

// Three weighted values along an axis: their sum, and its first two moments about the middle one,
// in steps.
template <class V>
struct AxisSums {
    V sum, first, second;
};
template <class V>
HD AxisSums<V> axis_sums(const V& low, const V& middle, const V& high)
{
    return {low + middle + high, high - low, low + high};
}

// Sums of w h v and, fourth, of w h over the 27 nodes: as they are, times the step from the middle
// node along each axis; of w h times two of these steps, too.
template <class R>
struct NodeSums {
    Four<R> all, by_x, by_y, by_z;
    Sym3<R> second;
};

// node(step) is where the memory is: it answers with what the node so many steps from the base
// counts for.
template <class R, class NodeAt>
HD NodeSums<R> node_sums(const Stencil<R>& s, NodeAt&& node)
{
    const auto weighted = [&](Int3 step, R w) {
        const NodeShare<R> n = node(step);
        const R wh = w * n.h;
        return four(wh * n.v, wh);
    };
    Four<R> sum[3], by_y[3], by_z[3];  // of planes
    R yy[3], yz[3], zz[3];
    UNROLL
    for (int i = 0; i < 3; ++i) {
        AxisSums<Four<R>> column[3];
        UNROLL
        for (int j = 0; j < 3; ++j)
            column[j] =
                axis_sums(weighted(Int3{i, j, 0}, s.w[0].z), weighted(Int3{i, j, 1}, s.w[1].z),
                          weighted(Int3{i, j, 2}, s.w[2].z));
        const auto along_y = [&](const auto& a, const auto& b, const auto& c) {
            return axis_sums(s.w[0].y * a, s.w[1].y * b, s.w[2].y * c);
        };
        const auto plain = along_y(column[0].sum, column[1].sum, column[2].sum);
        const auto tilted = along_y(column[0].first, column[1].first, column[2].first);
        sum[i] = plain.sum, by_y[i] = plain.first, by_z[i] = tilted.sum;
        yy[i] = last(plain.second), yz[i] = last(tilted.first);
        zz[i] = along_y(last(column[0].second), last(column[1].second), last(column[2].second)).sum;
    }
    const auto along_x = [&](const auto* each) {
        return axis_sums(s.w[0].x * each[0], s.w[1].x * each[1], s.w[2].x * each[2]);
    };
    const auto plain = along_x(sum), y = along_x(by_y), z = along_x(by_z);
    return {plain.sum,
            plain.first,
            y.sum,
            z.sum,
            {last(plain.second), along_x(yy).sum, along_x(zz).sum, last(y.first), last(z.first),
             along_x(yz).sum}};
}

// A symmetric matrix times its inverse is the identity times its determinant, the matrix here.
template <class R>
HD Sym3<R> adjugate(const Sym3<R>& A)
{
    return {A.yy * A.zz - A.yz * A.yz, A.xx * A.zz - A.xz * A.xz, A.xx * A.yy - A.xy * A.xy,
            A.xz * A.yz - A.xy * A.zz, A.xy * A.yz - A.xz * A.yy, A.xy * A.xz - A.yz * A.xx};
}

// The inverse of a symmetric matrix that has no negative eigenvalue. To one whose smallest is next
// to nothing so much of the identity is added that none is below `floor`: det / minors lies between
// a third of the smallest eigenvalue and all of it. `exact` if nothing was added.
template <class R>
HD Sym3<R> bounded_inverse(Sym3<R> A, R floor, bool& exact)
{
    Sym3<R> C = adjugate(A);
    const auto det = [&] { return A.xx * C.xx + A.xy * C.xy + A.xz * C.xz; };
    R d = det();
    const R m = trace(C);  // the sum of the principal minors
    exact = d >= floor * m && m > 0;
    if (!exact) {
        A = raised(A, m > 0 ? floor - max(d / m, R(0)) : floor);
        C = adjugate(A), d = det();
    }
    return (R(1) / d) * C;
}

// A velocity and its gradient.
template <class R>
struct LinearField {
    Vec3<R> v;  // [m/s]
    Mat3<R> C;  // [1/s]
};

// The gradient, per step, of the linear field that is nearest to velocities whose moments about
// their mean are B = <v r^T> and M = <r r^T>, r in steps: first the rotation that is nearest to
// them, then what is left. A rotation is so found exactly wherever the nodes say which it is, as
// those of a plane do; and a gradient in a direction in which no node has a neighbour is that of
// the rotation. Where M has a good inverse the two come to B M^-1 at once.  (32)
template <class R>
HD Mat3<R> fitted_gradient(const Mat3<R>& B, const Sym3<R>& M)
{
    constexpr R floor = R(1) / 256;
    bool exact;
    const Mat3<R> inverse = full(bounded_inverse(M, floor, exact));
    if (exact) return B * inverse;
    const Sym3<R> inertia = raised(R(-1) * M, trace(M));
    const Vec3<R> spin = {B.b.z - B.c.y, B.c.x - B.a.z, B.a.y - B.b.x};
    const Vec3<R> w = full(bounded_inverse(inertia, floor, exact)) * spin;
    const Mat3<R> W = {{0, w.z, -w.y}, {-w.z, 0, w.x}, {w.y, -w.x, 0}}, m = full(M);
    const Mat3<R> left = B - Mat3<R>{cross(w, m.a), cross(w, m.b), cross(w, m.c)};
    return W + left * inverse;
}

// What moves the point whose stencil is s; `held` is false where none of its nodes holds mass.
template <class R>
HD LinearField<R> fitted_field(const NodeSums<R>& n, const Stencil<R>& s,
                               std::type_identity_t<const Spacing<R>&> spacing, bool& held)
{
    const R weight = last(n.all);
    held = weight > R(1e-12);
    if (!held) return {};
    const R share = R(1) / weight;
    const Vec3<R> mean = {share * last(n.by_x), share * last(n.by_y), share * last(n.by_z)};
    const Vec3<R> v = share * first_three(n.all);
    const Mat3<R> B = {share * first_three(n.by_x) - mean.x * v,
                       share * first_three(n.by_y) - mean.y * v,
                       share * first_three(n.by_z) - mean.z * v};
    // From the nodes' mean to the point, in steps.
    const Vec3<R> r = (-spacing.per_dx) * s.d - Vec3<R>{1, 1, 1} - mean;
    Mat3<R> C = R(4) * B;  // all nodes count in full: M is I / 4, as in g2p.h
    if (weight < R(1) - R(1e-5)) {
        const Sym3<R>& q = n.second;
        C = fitted_gradient(B, {share * q.xx - mean.x * mean.x, share * q.yy - mean.y * mean.y,
                                share * q.zz - mean.z * mean.z, share * q.xy - mean.x * mean.y,
                                share * q.xz - mean.x * mean.z, share * q.yz - mean.y * mean.z});
    }
    return {v + C * r, spacing.per_dx * C};
}

// Carries a Gaussian on through so many substeps of dt [s] each, in all of which the field around
// it is this one: a rotation stays one. A substep that would turn its neighbourhood inside out is
// cut: for |dt C| <= 1/2, det(I + dt C) > 0.  (33)
template <class R>
HD void carry(Gaussian<R>& g, const LinearField<R>& field, R dt, int substeps)
{
    const Mat3<R>& C = field.C;
    const R size_squared = dt * dt * (dot(C.a, C.a) + dot(C.b, C.b) + dot(C.c, C.c));
    const R step = size_squared > R(0.25) ? dt * (R(0.5) / std::sqrt(size_squared)) : dt;
    Vec3<R> v = field.v;  // where it is by then
    for (int n = 0; n < substeps; ++n) {
        g.x = g.x + dt * v;
        g.F = g.F + step * (C * g.F);
        v = v + step * (C * v);
    }
}

// What moves the point x, through the nodes around it: node(step) as in node_sums().
template <class R, class NodeAt>
HD LinearField<R> field_at(Vec3<R> x, std::type_identity_t<const Spacing<R>&> spacing, bool& held,
                           NodeAt&& node)
{
    const Stencil<R> s = stencil(x, spacing);
    return fitted_field(node_sums(s, node), s, spacing, held);
}

// So many substeps of g, of dt [s] each. False where no node holds mass: it stays.
template <class R, class NodeAt>
HD bool deform(Gaussian<R>& g, std::type_identity_t<const Spacing<R>&> spacing, R dt, int substeps,
               NodeAt&& node)
{
    bool held;
    const LinearField<R> field = field_at(g.x, spacing, held, node);
    if (held) carry(g, field, dt, substeps);
    return held;
}

// Within the walls.
template <class R>
HD void keep_within(Gaussian<R>& g, const Walls<R>& walls)
{
    Particle<R> point{};
    point.x = g.x;
    confine(point, walls);
    g.x = point.x;
}

// Out of tools, all the way, for it has no neighbours whose strain would have to hear of it (19);
// within the walls; with `blades` on its side of each. Tools are looked for `passes` times, at
// least twice if ever: what leaves one all at once may be in another. True if a tool moved it. (34)
template <class R>
HD bool keep_out(Gaussian<R>& g, const Colliders<R>& tools, const Mask& mask, int passes,
                 bool blades, const Walls<R>& walls, R dx)
{
    Particle<R> point{};
    point.x = g.x, point.sides = g.sides;
    std::uint32_t touched = 0;
    if (blades && passes > 0) cut(point, tools, mask, dx, touched);
    const int looks = passes > 0 ? max(passes, 2) : 0;
    const R depth =
        project(point, tools, mask, looks, PushoutLimits<R>{0, 0, 0, 0}, R(0), R(1), touched);
    g.x = point.x, g.sides = point.sides;
    keep_within(g, walls);
    return depth > 0;
}

// Splits one; returns the second. Both stay between the walls.
template <class R>
HD Gaussian<R> split(Gaussian<R>& g, Vec3<R> way, const WallOptions& walls)
{
    Gaussian<R> second = g;
    g.x = put_between(walls, g.x - way), second.x = put_between(walls, second.x + way);
    return second;
}

template <class R>
HD Gaussian<R> gaussian_beside(const Particle<R>& p, Vec3<R> way, const WallOptions& walls)
{
    Gaussian<R> g = gaussian_at(put_between(walls, p.x + way), p.object);
    g.sides = p.label();
    return g;
}

// Moves a Gaussian as part of a rigid body.
template <class R>
HD void move(Gaussian<R>& g, const RigidMotion<R>& motion)
{
    const Mat3<R> Q = rotation(motion.q);
    g.x = motion.p + Q * g.x;
    g.F = Q * g.F;
}

template <class R>
HD bool sound(const Gaussian<R>& g)
{
    const R sum = g.x.x + g.x.y + g.x.z + determinant(g.F);
    return sum - sum == 0;
}

// Back to where it was, where a number is none. True if that was needed.
template <class R>
HD bool repair(Gaussian<R>& g, const Gaussian<R>& before)
{
    if (sound(g)) return false;
    g = before;
    return true;
}

}  // namespace knead
