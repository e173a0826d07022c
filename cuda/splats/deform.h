// Deformation of Gaussians by the clay around them: a Gaussian is advected with the grid velocity,
// and deformed by its gradient. The field is fitted to the nodes that hold clay, because half of
// the nodes at a photographed surface hold none.  (31)-(34)
#pragma once
#include "cuda/math/rotation.h"
#include "cuda/mpm/edit.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/project.h"
#include "cuda/mpm/stencil.h"

namespace knead {

// The centre of a splat, and the deformation of its neighbourhood since it was attached.
template <class R>
struct Gaussian {
    Vec3<R> x;   // [m]
    Mat3<R> F;   // total deformation gradient, without a return map: else splats would keep their
                 // size while clay spreads, and holes would open between them [1]
    int object;  // the object whose clay moves it
    std::uint32_t sides;  // side of a cut, and whether it is held: as Particle::sides
    HD bool still() const { return (sides & Particle<R>::still_bit) != 0; }
    HD std::uint32_t label() const { return sides & ~Particle<R>::still_bit; }
    HD void hold(bool held) { sides = label() | (held ? Particle<R>::still_bit : 0); }
};

// Edits of Gaussians. A split Gaussian is displaced by -way, and a new one is added at +way. Other
// new Gaussians are added beside particles, with the particle's object and label, or at given
// positions.
struct GaussianSplit {
    int index;
    Vec3<double> way;  // [m]
};
struct GaussianBeside {
    int particle;      // id
    Vec3<double> way;  // from it [m]
};
struct GaussianPlace {  // undeformed
    Vec3<float> x;      // [m]
    int object;
};

// An undeformed Gaussian at x.
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

// Weight of a node of mass m, where the lightest particle has the mass 1 / per_mass: below 1 if the
// node has less mass than that particle. The velocity of such a node comes from a negligible amount
// of clay and may be arbitrary.  (31)
template <class R>
HD R share(R m, R per_mass)
{
    return min(per_mass * m, R(1));
}

// A node's velocity and weight.
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

// Three weighted values along an axis: their sum, and the first two moments about the middle one,
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

// Sums over the 27 nodes of w h v and, as fourth component, of w h: plain, and times the step from
// the middle node along each axis; of w h also times two of these steps.
template <class R>
struct NodeSums {
    Four<R> all, by_x, by_y, by_z;
    Sym3<R> second;
};

// node(step) accesses the memory: it returns the NodeShare of the node at `step` from the base.
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

// Adjugate: a symmetric matrix times it is the determinant times the identity.
template <class R>
HD Sym3<R> adjugate(const Sym3<R>& A)
{
    return {A.yy * A.zz - A.yz * A.yz, A.xx * A.zz - A.xz * A.xz, A.xx * A.yy - A.xy * A.xy,
            A.xz * A.yz - A.xy * A.zz, A.xy * A.yz - A.xz * A.yy, A.xy * A.xz - A.yz * A.xx};
}

// The inverse of a positive semidefinite matrix. If the matrix is nearly singular, a multiple of
// the identity is added, so that no eigenvalue is below `floor`: det / minors is between a third of
// the smallest eigenvalue and the smallest eigenvalue. `exact`: nothing was added.
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

// The gradient, per step, of the linear velocity field fitted by least squares to velocities with
// the moments B = <v r^T> and M = <r r^T> about their mean, r in steps. First the best-fitting
// rotation is computed, then the remainder. So a rotation is reproduced exactly if the nodes
// determine it, as nodes in a plane do; in a direction in which no node has a neighbour the
// gradient is that of the rotation. If M is well conditioned, rotation and remainder sum to B M^-1.
// (32)
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

// The velocity field at the point whose stencil is s; `held` is false if none of its nodes holds
// mass.
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
    Mat3<R> C = R(4) * B;  // all nodes have full weight: M is I / 4, as in g2p.h
    if (weight < R(1) - R(1e-5)) {
        const Sym3<R>& q = n.second;
        C = fitted_gradient(B, {share * q.xx - mean.x * mean.x, share * q.yy - mean.y * mean.y,
                                share * q.zz - mean.z * mean.z, share * q.xy - mean.x * mean.y,
                                share * q.xz - mean.x * mean.z, share * q.yz - mean.y * mean.z});
    }
    return {v + C * r, spacing.per_dx * C};
}

// Advances a Gaussian by `substeps` substeps of dt [s] in the constant field `field`: a rotation
// remains a rotation. dt C is limited so that the neighbourhood is not inverted: for |dt C| <= 1/2,
// det(I + dt C) > 0.  (33)
template <class R>
HD void carry(Gaussian<R>& g, const LinearField<R>& field, R dt, int substeps)
{
    const Mat3<R>& C = field.C;
    const R size_squared = dt * dt * (dot(C.a, C.a) + dot(C.b, C.b) + dot(C.c, C.c));
    const R step = size_squared > R(0.25) ? dt * (R(0.5) / std::sqrt(size_squared)) : dt;
    Vec3<R> v = field.v;  // velocity at its current position
    for (int n = 0; n < substeps; ++n) {
        g.x = g.x + dt * v;
        g.F = g.F + step * (C * g.F);
        v = v + step * (C * v);
    }
}

// The velocity field at x from the nodes around it: node(step) as in node_sums().
template <class R, class NodeAt>
HD LinearField<R> field_at(Vec3<R> x, std::type_identity_t<const Spacing<R>&> spacing, bool& held,
                           NodeAt&& node)
{
    const Stencil<R> s = stencil(x, spacing);
    return fitted_field(node_sums(s, node), s, spacing, held);
}

// Advances g by `substeps` substeps of dt [s]. Returns false, and leaves g unchanged, if no node
// holds mass.
template <class R, class NodeAt>
HD bool deform(Gaussian<R>& g, std::type_identity_t<const Spacing<R>&> spacing, R dt, int substeps,
               NodeAt&& node)
{
    bool held;
    const LinearField<R> field = field_at(g.x, spacing, held, node);
    if (held) carry(g, field, dt, substeps);
    return held;
}

// Clamps to the walls.
template <class R>
HD void keep_within(Gaussian<R>& g, const Walls<R>& walls)
{
    Particle<R> point{};
    point.x = g.x;
    confine(point, walls);
    g.x = point.x;
}

// Pushes a Gaussian out of tools entirely, since no strain depends on it (19); keeps it within the
// walls and, with `blades`, on its side of each blade. In at most `passes` iterations, at least two
// if any: a Gaussian pushed out of one tool may be in another. Returns true if a tool moved it.
// (34)
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

// Splits a Gaussian; returns the second. Both stay between the walls.
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

// Resets a Gaussian with non-finite values to `before`. Returns true if that was needed.
template <class R>
HD bool repair(Gaussian<R>& g, const Gaussian<R>& before)
{
    if (sound(g)) return false;
    g = before;
    return true;
}

}  // namespace knead
