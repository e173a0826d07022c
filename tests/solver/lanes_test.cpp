// Many particles at once, and whole rows of nodes: against the formulas one by one.
#include <cmath>
#include <cstring>

#include "cuda/mpm/g2p.h"
#include "cuda/mpm/p2g.h"
#include "cuda/mpm/project.h"
#include "host/hands/hands.h"
#include "host/solver/cpu/levels.h"
#include "host/solver/cpu/transfer.h"
#include "host/solver/reference.h"
#include "tests/solver/clay.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test

template <class R>
class LanesTest : public ::testing::Test {
};
TYPED_TEST_SUITE(LanesTest, Scalars);

constexpr double dx = 1.0 / 32, dt = 1e-4;

// A group of `size` particles, their base nodes in the block at the lattice's origin.
template <class R>
struct Some {
    std::vector<Particle<R>> q;
    Group<R> group;
    Some(Draw& draw, int size, double strain) : q(std::size_t(Group<R>::count))
    {
        for (Particle<R>& p : q) {
            const auto any = [&] { return draw.in(0.5, 4.5) * dx; };
            p.x = cast<R>(Vec3<double>{any(), any(), any()});
            p.v = cast<R>(draw.vector(2)), p.C = cast<R>(draw.matrix(50));
            p.e = cast<R>(draw.strain(strain)), p.k = R(draw.in(0, 1));
            p.object = 3, p.sides = 2;
        }
        group.size = size;
        for (int l = 0; l < Group<R>::count; ++l) {
            group.index[l] = std::min(l, size - 1);
            group.of[l] = &q[std::size_t(group.index[l])];
        }
    }
};

TYPED_TEST(LanesTest, TheLogarithmIsThatOfTheLibrary)
{
    using R = TypeParam;
    Draw draw(1);
    double worst = 0;
    const auto check = [&](R x) {
        const long double exact = std::log1p((long double)(x));
        const double error = double(std::abs(log_of_one_plus(Lanes<R>(x))[0] - exact));
        const double unit = std::numeric_limits<R>::epsilon() * std::abs(double(exact));
        if (x != 0) worst = std::max(worst, error / unit);
    };
    for (int n = 0; n < 200000; ++n) {
        check(R(draw.power(either<R>(-30, -250), 6)));
        check(R(-draw.power(either<R>(-30, -250), -1e-3)));
    }
    check(crushed<R>);
    EXPECT_LT(worst, 3);
    EXPECT_EQ(log_of_one_plus(Lanes<R>(R(0)))[0], R(0));
}

TYPED_TEST(LanesTest, AParticleComesBackFromItsLaneToTheBit)
{
    using R = TypeParam;
    Draw draw(2);
    for (int size : {1, Group<R>::count - 1, Group<R>::count}) {
        Some<R> some(draw, size, 0.1);
        const std::vector<Particle<R>> before = some.q;
        const Particle<Lanes<R>> p = load(some.group);
        for (int l = 0; l < size; ++l) {
            const Particle<R>& one = before[std::size_t(l)];
            EXPECT_EQ(p.x.x[l], one.x.x);
            EXPECT_EQ(p.v.y[l], one.v.y);
            EXPECT_EQ(p.C.b.z[l], one.C.b.z);
            EXPECT_EQ(p.C.c.x[l], one.C.c.x);
            EXPECT_EQ(p.e.yy[l], one.e.yy);
            EXPECT_EQ(p.e.yz[l], one.e.yz);
            EXPECT_EQ(p.k[l], one.k);
        }
        for (Particle<R>& one : some.q) one = {{}, {}, {}, {}, 0, one.object, one.sides};
        store(p, some.group);
        for (std::size_t l = 0; l < std::size_t(size); ++l)
            EXPECT_EQ(0, std::memcmp(&some.q[l], &before[l], sizeof before[l])) << l;
    }
}

TYPED_TEST(LanesTest, RowsHandOutWhatParticlesDoNodeByNode)
{
    using R = TypeParam;
    Draw draw(3);
    const Material<R> m = clay<R>(Elasticity::neo_hookean, Plasticity::none);
    for (int n = 0; n < 100; ++n) {
        const Some<R> some(draw, Group<R>::count, 0.1);
        Tile<R> rows{};
        const Impulses<R> from = impulses(some.group, m, Vec3<R>{}, R(dx), R(dt));
        std::vector<Node<double>> plain(tile_nodes);
        for (int l = 0; l < Group<R>::count; ++l) {
            const Stencil<R> s = from.stencils[l];
            scatter_rows(from.base[l], from.by_x[l], from.by_y[l], from.by_z[l], s,
                         [&](int j, int k, const Row<R>& share) {
                             add(share, rows.node + tile_index(s.base + Int3{0, j, k}));
                         });
            const auto q = cast<double>(*some.group.of[l]);
            scatter(q, cast<double>(m), stencil(q.x, dx), dx, dt,
                    [&](Int3 step, const Node<double>& share) {
                        Node<double>& to = plain[std::size_t(tile_index(s.base + step))];
                        to.p = to.p + share.p, to.m += share.m;
                    });
        }
        double scale = 0;
        for (const Node<double>& node : plain) scale = std::max(scale, length(node.p));
        for (std::size_t t = 0; t < plain.size(); ++t) {
            const Vec3<double> off = cast<double>(rows.node[t].p) - plain[t].p;
            EXPECT_LT(length(off), either<R>(2e-5, 1e-13) * scale) << t;
            EXPECT_NEAR(rows.node[t].m, plain[t].m, either<R>(1e-5, 1e-13)) << t;
        }
    }
}

TYPED_TEST(LanesTest, RowsBringBackWhatParticlesGatherNodeByNode)
{
    using R = TypeParam;
    Draw draw(4);
    for (int n = 0; n < 100; ++n) {
        Some<R> some(draw, Group<R>::count, 0.1);
        Tile<R> tile{};
        for (Node<R>& node : tile.node) node = {cast<R>(draw.vector(3)), R(draw.in(0, 2))};
        const std::vector<Particle<R>> before = some.q;
        constexpr double mass = 1;  // of nodes 0 to 2: every other particle is a crumb
        const auto moved = gather_and_move(some.group, R(mass), R(dx), R(dt), [&](int, Int3 base) {
            return tile.node + tile_index(base);
        });
        for (std::size_t l = 0; l < before.size(); ++l) {
            auto q = cast<double>(before[l]);
            const Stencil<double> s = stencil(q.x, dx);
            const auto sum = gather(q, s, dx, [&](Int3 step) {
                const Node<R>& node = tile.node[tile_index(s.base + step)];
                return four(cast<double>(node.p), double(node.m));
            });
            const double per_cell = mass_around(sum) / mass;
            EXPECT_NEAR(moved.per_cell.of[l], per_cell, 1e-6);
            damp_isolated_particle(q.C, tile.node[tile_index(s.base + nearest_node)].m / mass);
            const Particle<R>& now = some.q[l];
            EXPECT_LT(length(cast<double>(now.v) - q.v), either<R>(3e-6, 1e-14));
            EXPECT_LT(size(cast<double>(now.C) - q.C), either<R>(1e-3, 1e-11));
            EXPECT_LT(size(cast<double>(now.e) - advance_b(q.e, q.C, dt)), either<R>(1e-6, 1e-14));
            EXPECT_LT(length(cast<double>(now.x) - (q.x + dt * q.v)), either<R>(1e-7, 1e-15));
            EXPECT_EQ(now.k, before[l].k);
        }
    }
}

TYPED_TEST(LanesTest, NoParticleThatFlowsIsPassedOver)
{
    using R = TypeParam;
    Draw draw(5);
    for (Elasticity elasticity : elasticities)
        for (Plasticity plasticity : plasticities) {
            if (!go_together(elasticity, plasticity)) continue;
            Material<R> m = clay<R>(elasticity, plasticity);
            m.hardening = R(2e4), m.yield_floor = R(1e3);
            int calm = 0, flowing = 0;
            for (int n = 0; n < 300; ++n) {
                Some<R> some(draw, Group<R>::count, 0.06);
                const unsigned looked_at = near_yield_mask(load(some.group), m);
                for (int l = 0; l < Group<R>::count; ++l) {
                    const bool flows_here = yield(some.q[std::size_t(l)], m, R(dt));
                    EXPECT_TRUE(!flows_here || (looked_at >> l & 1));
                    flowing += flows_here, calm += !(looked_at >> l & 1);
                }
            }
            if (plasticity == Plasticity::von_mises && elasticity == Elasticity::neo_hookean) {
                EXPECT_GT(calm, 50);
                EXPECT_GT(flowing, 50);
            }
        }
}

TYPED_TEST(LanesTest, AStrainThatIsNotANumberIsLookedAt)
{
    using R = TypeParam;
    Draw draw(6);
    Some<R> some(draw, Group<R>::count, 0.001);
    some.q[1].e.xy = std::numeric_limits<R>::quiet_NaN();
    const Particle<Lanes<R>> p = load(some.group);
    EXPECT_TRUE(near_yield_mask(p, clay<R>(Elasticity::neo_hookean, Plasticity::von_mises)) >> 1 &
                1);
    EXPECT_FALSE(sound(p));
}

// Two balls of different stuff fall on each other.
Given two_balls()
{
    Given s;
    s.lattice = {{32, 32, 32}, dx};
    s.walls = walls_inside(s.lattice, 3, ContactMode::separate, 0.4);
    s.gravity = {0, -9.81, 0};
    s.materials = {clay<double>(Elasticity::neo_hookean, Plasticity::von_mises),
                   clay<double>(Elasticity::hencky, Plasticity::drucker_prager)};
    for (Material<double>& m : s.materials) m.volume = dx * dx * dx / 8, m.mass = m.volume * 1000;
    for (int n = 0; n < 64 * 64 * 64; ++n) {
        Particle<double> q{};
        q.x = dx / 2 * Vec3<double>{n % 64 + 0.5, n / 64 % 64 + 0.5, n / 4096 + 0.5};
        const auto in = [&](double height) {
            return length(q.x - Vec3<double>{0.5, height, 0.5}) < 0.12;
        };
        if (!in(0.3) && !in(0.52)) continue;
        q.object = in(0.52);
        q.v = {0, q.object ? -1.5 : 0.0, 0};
        s.particles.push_back(q);
    }
    return s;
}

TEST(Solver, EveryLevelOfTheProcessorAgreesWithTheOracle)
{
    const Given s = two_balls();
    Motion still;
    still.from.assign(2 * joint_count, {{1, 0, 0, 0}, {0, 0, 0}}), still.to = still.from;
    Reference oracle(s);
    for (int f = 0; f < 3; ++f) oracle.advance(still, 0.01);
    const auto wanted = oracle.particles();
    for (MakeSolver make : cpu_levels()) {
        const auto solver = make(s);
        for (int f = 0; f < 3; ++f) solver->advance(still, 0.01);
        const auto q = solver->particles();
        ASSERT_EQ(q.size(), wanted.size());
        double furthest = 0, moved = 0;
        for (std::size_t i = 0; i < q.size(); ++i) {
            furthest = std::max(furthest, length(q[i].x - wanted[i].x));
            moved = std::max(moved, length(q[i].x - s.particles[i].x));
        }
        EXPECT_LT(furthest, 2e-3 * dx) << solver->name();
        EXPECT_GT(moved, dx) << solver->name();
    }
}

}  // namespace
}  // namespace knead
