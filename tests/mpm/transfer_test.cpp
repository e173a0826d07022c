// Particle to grid and back by plain loops: what must be conserved, what must be reproduced, and
// what the node and particle guards must catch.
#include <cmath>
#include <vector>

#include "cuda/mpm/g2p.h"
#include "cuda/mpm/grid.h"
#include "cuda/mpm/p2g.h"
#include "cuda/mpm/plasticity.h"
#include "cuda/mpm/project.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

template <class R>
class TransferTest : public ::testing::Test {
};
TYPED_TEST_SUITE(TransferTest, Scalars);

// A box of particles and nodes without tools.
template <class R>
struct World {
    Lattice<R> lattice{{24, 24, 24}, R(1) / 24};
    Walls<R> walls = walls_on<R>(lattice, walls_inside(lattice, 2, ContactMode::separate, 0));
    Material<R> material{};
    std::vector<Particle<R>> particles;
    std::vector<Node<R>> nodes;
    long clipped = 0;

    World()
    {
        material.density = 1000;
        material.mu = R(1e5 / 2.6), material.lambda = R(0.3e5 / (1.3 * 0.4));
        material.volume = R(std::pow(double(lattice.dx) / 2, 3));
        material.mass = material.volume * material.density;
    }
    // Two particles per axis and cell where inside(x), shaken by up to a share of their spacing.
    template <class Inside>
    void fill(Draw& draw, double shake, Inside&& inside)
    {
        const double half = double(lattice.dx) / 2;
        for (int k = 0; k < 48; ++k)
            for (int j = 0; j < 48; ++j)
                for (int i = 0; i < 48; ++i) {
                    Particle<R> q{};
                    const Vec3<double> at = half * Vec3<double>{i + 0.5, j + 0.5, k + 0.5};
                    if (!inside(at)) continue;
                    q.x = cast<R>(at + shake * half * draw.vector(0.5));
                    particles.push_back(q);
                }
    }
    void fill_ball(Draw& draw, double radius)
    {
        fill(draw, 1, [&](Vec3<double> x) {
            return length(x - Vec3<double>{0.5, 0.5, 0.5}) < radius;
        });
    }
    void p2g(R dt)
    {
        nodes.assign(std::size_t(lattice.node_count()), Node<R>{});
        for (const Particle<R>& q : particles) {
            const Stencil<R> s = stencil(q.x, lattice.dx);
            scatter(q, material, s, lattice.dx, dt, [&](Int3 step, const Node<R>& share) {
                Node<R>& n = nodes[std::size_t(lattice.index(s.base + step))];
                n.p = n.p + share.p, n.m += share.m;
            });
        }
    }
    void update_nodes(R dt, Vec3<R> gravity)
    {
        for (int i = 0; i < lattice.node_count(); ++i) {
            bool outran;
            Node<R>& n = nodes[std::size_t(i)];
            n = update(n, lattice.node_at(i), lattice, walls, gravity, dt, outran,
                       [](Vec3<R>, Vec3<R> v) { return v; });
            clipped += outran;
        }
    }
    void g2p(R dt)
    {
        for (Particle<R>& q : particles) {
            const Stencil<R> s = stencil(q.x, lattice.dx);
            gather(q, s, lattice.dx,
                   [&](Int3 step) { return nodes[std::size_t(lattice.index(s.base + step))].p; });
            q.e = advance_b(q.e, q.C, dt);
            q.x = q.x + dt * q.v;
            yield(q, material, dt);
        }
    }
    void step(R dt, Vec3<R> gravity = {})
    {
        p2g(dt);
        update_nodes(dt, gravity);
        g2p(dt);
    }
};

// Sums over everything, in double: angular momentum about the origin.
struct Sums {
    double m = 0;
    Vec3<double> p{}, L{};
};

// An affine velocity carries angular momentum dx^2 / 4 m times twice its spin.  [Jiang 2015]
template <class R>
Sums of_particles(const World<R>& w)
{
    Sums s;
    const double m = double(w.material.mass),
                 inertia = m * double(w.lattice.dx) * double(w.lattice.dx) / 4;
    for (const Particle<R>& q : w.particles) {
        const Vec3<double> x = cast<double>(q.x), v = cast<double>(q.v);
        const Mat3<double> C = cast<double>(q.C);
        s.m += m;
        s.p = s.p + m * v;
        s.L = s.L + m * cross(x, v) +
              inertia * Vec3<double>{C.b.z - C.c.y, C.c.x - C.a.z, C.a.y - C.b.x};
    }
    return s;
}

// `moving`: the nodes hold velocities already.
template <class R>
Sums of_nodes(const World<R>& w, bool moving)
{
    Sums s;
    for (int i = 0; i < w.lattice.node_count(); ++i) {
        const Node<R>& n = w.nodes[std::size_t(i)];
        const Vec3<double> p = (moving ? double(n.m) : 1) * cast<double>(n.p);
        s.m += double(n.m);
        s.p = s.p + p;
        s.L = s.L + cross(cast<double>(w.lattice.position(w.lattice.node_at(i))), p);
    }
    return s;
}

void expect_equal(const Sums& a, const Sums& b, double tolerance)
{
    EXPECT_NEAR(a.m, b.m, tolerance * a.m);
    EXPECT_LT(length(a.p - b.p), tolerance * a.m);
    EXPECT_LT(length(a.L - b.L), tolerance * a.m);
}

TYPED_TEST(TransferTest, ScatterIsItsDefinitionNodeByNode)
{
    using R = TypeParam;
    Draw draw(1);
    World<R> w;
    const double dx = double(w.lattice.dx), dt = 1e-3, m = double(w.material.mass),
                 V = double(w.material.volume);
    for (int round = 0; round < 200; ++round) {
        Particle<R> q{};
        q.x = cast<R>(Vec3<double>{0.5, 0.5, 0.5} + draw.vector(0.2)), q.v = cast<R>(draw.vector());
        q.C = cast<R>(draw.matrix(10)), q.e = cast<R>(draw.strain(0.1));
        w.particles = {q};
        w.p2g(R(dt));
        const Mat3<double> tau = full(cast<double>(kirchhoff_stress(q, w.material)));
        const auto spline = [](double t) {
            t = std::abs(t);
            return t < 0.5 ? 0.75 - t * t : t < 1.5 ? 0.5 * (1.5 - t) * (1.5 - t) : 0;
        };
        for (int i = 0; i < w.lattice.node_count(); ++i) {
            const Vec3<double> d =
                cast<double>(w.lattice.position(w.lattice.node_at(i))) - cast<double>(q.x);
            const double weight = spline(d.x / dx) * spline(d.y / dx) * spline(d.z / dx);
            const Vec3<double> carried = cast<double>(q.v) + cast<double>(q.C) * d;
            const Vec3<double> p = weight * (m * carried - (dt * V * 4 / (dx * dx)) * (tau * d));
            const Node<R>& n = w.nodes[std::size_t(i)];
            EXPECT_NEAR(double(n.m), weight * m, either<R>(2e-6, 1e-14) * m);
            EXPECT_LT(length(cast<double>(n.p) - p), either<R>(1e-5, 1e-13) * m);
        }
    }
}

TYPED_TEST(TransferTest, MassAndBothMomentaSurviveEachTransfer)
{
    using R = TypeParam;
    Draw draw(2);
    World<R> w;
    w.fill_ball(draw, 0.25);
    for (Particle<R>& q : w.particles) {
        q.v = cast<R>(draw.vector()), q.C = cast<R>(draw.matrix(20));
        q.e = cast<R>(draw.strain(0.05));  // stress moves momentum about and makes none
    }
    const Sums before = of_particles(w);
    w.p2g(R(1e-4));
    const Sums there = of_nodes(w, false);
    expect_equal(before, there, either<R>(1e-6, 1e-12));
    w.update_nodes(R(1e-4), {});
    expect_equal(there, of_nodes(w, true), either<R>(1e-6, 1e-12));
    w.g2p(0);
    expect_equal(before, of_particles(w), either<R>(2e-6, 1e-12));
}

TYPED_TEST(TransferTest, AThousandRoundTripsLoseNoMomentum)
{
    using R = TypeParam;
    Draw draw(3);
    World<R> w;
    w.fill_ball(draw, 0.1);
    for (Particle<R>& q : w.particles) q.v = cast<R>(draw.vector() + Vec3<double>{1, 0, 0});
    const Sums before = of_particles(w);
    for (int trip = 0; trip < 1000; ++trip) w.step(0);
    expect_equal(before, of_particles(w), either<R>(3e-5, 1e-12));
}

TYPED_TEST(TransferTest, AnAffineVelocityFieldComesBackWhole)
{
    using R = TypeParam;
    Draw draw(4);
    for (int round = 0; round < 10; ++round) {
        World<R> w;
        w.fill_ball(draw, 0.15);
        const Mat3<double> A = draw.matrix(2);
        const Vec3<double> at_origin = draw.vector();
        for (Particle<R>& q : w.particles)
            q.v = cast<R>(at_origin + A * cast<double>(q.x)), q.C = cast<R>(A);
        w.step(0);
        for (const Particle<R>& q : w.particles) {
            EXPECT_LT(length(cast<double>(q.v) - at_origin - A * cast<double>(q.x)),
                      either<R>(5e-6, 1e-14));
            EXPECT_LT(size(cast<double>(q.C) - A), either<R>(1e-3, 1e-12));
        }
    }
}

TYPED_TEST(TransferTest, AUniformStressPushesNoNodeInside)
{
    using R = TypeParam;
    Draw draw(5);
    World<R> w;
    w.fill(draw, 0, [](Vec3<double> x) {
        return std::min({x.x, x.y, x.z}) > 0.2 && std::max({x.x, x.y, x.z}) < 0.8;
    });
    const Sym3<R> e = cast<R>(draw.strain(0.1));
    for (Particle<R>& q : w.particles) q.e = e;
    w.p2g(R(1e-3));
    int inner = 0;
    double border = 0;
    for (int i = 0; i < w.lattice.node_count(); ++i) {
        const Vec3<R> x = w.lattice.position(w.lattice.node_at(i));
        const Node<R>& n = w.nodes[std::size_t(i)];
        if (!(n.m > 0)) continue;
        const double v = double(length(n.p)) / double(n.m);
        if (std::min({x.x, x.y, x.z}) > R(0.3) && std::max({x.x, x.y, x.z}) < R(0.7)) {
            ++inner;
            EXPECT_LT(v, either<R>(2e-5, 1e-13));
        } else {
            border = std::max(border, v);
        }
    }
    EXPECT_GT(inner, 500);
    EXPECT_GT(border, 0.05);
}

TYPED_TEST(TransferTest, FreeFallIsExactAndUnstrained)
{
    using R = TypeParam;
    Draw draw(6);
    World<R> w;
    w.fill_ball(draw, 0.1);
    std::vector<Particle<R>> start = w.particles;
    const double dt = 1e-3, g = 9.81;
    const int steps = 150;
    for (int k = 0; k < steps; ++k) w.step(R(dt), {0, R(-g), 0});
    for (std::size_t i = 0; i < start.size(); ++i) {
        const Particle<R>& q = w.particles[i];
        const Vec3<double> moved = cast<double>(q.x) - cast<double>(start[i].x);
        EXPECT_LT(length(cast<double>(q.v) - Vec3<double>{0, -g * steps * dt, 0}),
                  either<R>(3e-4, 1e-12));
        EXPECT_LT(length(moved - Vec3<double>{0, -g * dt * dt * steps * (steps + 1) / 2, 0}),
                  either<R>(3e-5, 1e-13));
        EXPECT_LT(double(size(q.e)), either<R>(1e-4, 1e-12));
    }
    EXPECT_EQ(w.clipped, 0);
}

TYPED_TEST(TransferTest, ASpinningBallKeepsItsAngularMomentumAndGainsNoEnergy)
{
    using R = TypeParam;
    Draw draw(7);
    World<R> w;
    w.fill_ball(draw, 0.15);
    const Vec3<double> spin{2, 5, -3}, centre{0.5, 0.5, 0.5};
    for (Particle<R>& q : w.particles) {
        const auto turning = [&](Vec3<double> r) { return cross(spin, r); };
        q.v = cast<R>(turning(cast<double>(q.x) - centre));
        q.C = cast<R>(Mat3<double>{turning({1, 0, 0}), turning({0, 1, 0}), turning({0, 0, 1})});
    }
    const auto kinetic = [&] {
        double sum = 0;
        for (const Particle<R>& q : w.particles) sum += double(dot(q.v, q.v));
        return sum;
    };
    const Sums before = of_particles(w);
    const double energy = kinetic();
    const int steps = 1000;
    for (int k = 0; k < steps; ++k) w.step(R(5e-4));  // three quarters of a turn
    const Sums after = of_particles(w);
    // About the centre, which stays where it is.
    const Vec3<double> L = before.L - cross(centre, before.p), M = after.L - cross(centre, after.p);
    EXPECT_LT(length(M - L), either<R>(1e-4, 1e-11) * length(L));
    EXPECT_LT(length(after.p - before.p), either<R>(1e-5, 1e-13) * before.m);
    EXPECT_LT(kinetic(), energy * 1.0001);
    EXPECT_GT(kinetic(), energy * 0.9);
}

TYPED_TEST(TransferTest, ARegisterOfFourGathersTheSameBitsAsThreeNumbers)
{
    using R = TypeParam;
    Draw draw(8);
    World<R> w;
    w.fill_ball(draw, 0.1);
    for (Particle<R>& q : w.particles) q.v = cast<R>(draw.vector());
    w.p2g(0);
    w.update_nodes(R(1e-3), {});
    for (const Particle<R>& particle : w.particles) {
        Particle<R> one = particle, other = particle;
        const Stencil<R> s = stencil(particle.x, w.lattice.dx);
        const auto at = [&](Int3 step) {
            return w.nodes[std::size_t(w.lattice.index(s.base + step))];
        };
        gather(one, s, w.lattice.dx, [&](Int3 step) { return at(step).p; });
        gather(other, s, w.lattice.dx, [&](Int3 step) { return four(at(step)); });
        EXPECT_LT(double(length(one.v - other.v)), either<R>(1e-6, 1e-15));
        EXPECT_LT(double(size(one.C - other.C)), either<R>(1e-4, 1e-13));
    }
}

TYPED_TEST(TransferTest, StrainFollowsTheDeformationAndKeepsSmallDigits)
{
    using R = TypeParam;
    Draw draw(9);
    for (int round = 0; round < 3000; ++round) {
        const double scale = draw.power(-9, -0.7), dt = 1e-3;
        const Sym3<R> e = cast<R>(scale * symmetric(draw.matrix()));
        const Mat3<R> C = cast<R>((scale / dt) * draw.matrix());
        const Mat3<double> L = double(R(dt)) * cast<double>(C), E = full(cast<double>(e));
        const Mat3<double> exact = E + L * E + E * transpose(L) + L * E * transpose(L) + L +
                                   transpose(L) + L * transpose(L);
        EXPECT_LT(size(cast<double>(advance_b(e, C, R(dt))) - symmetric(exact)),
                  either<R>(2e-6, 4e-15) * scale);
    }
}

}  // namespace
}  // namespace knead
