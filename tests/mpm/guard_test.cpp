// Nodes and particles at the edges of what is sane: walls, empty and nearly empty nodes, speeds
// beyond a cell per substep, non-finite numbers.
#include <cmath>
#include <limits>

#include "cuda/mpm/g2p.h"
#include "cuda/mpm/grid.h"
#include "cuda/mpm/project.h"
#include "cuda/mpm/stencil.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

template <class R>
class GuardTest : public ::testing::Test {
};
TYPED_TEST_SUITE(GuardTest, Scalars);

template <class R>
struct NodeArrays {
    Lattice<R> lattice{{16, 20, 24}, R(0.1)};
    WallOptions options = walls_inside(lattice, 3, ContactMode::separate, 0.5);
    Walls<R> walls = walls_on<R>(lattice, options);
    bool clipped = false;

    Node<R> update(const Node<R>& node, Int3 n, Vec3<R> gravity = {}, R dt = R(1e-3))
    {
        return knead::update(node, n, lattice, walls, gravity, dt, clipped,
                             [](Vec3<R>, Vec3<R> v) { return v; });
    }
};

TYPED_TEST(GuardTest, ANodeFallsWithGravityAndAnEmptyOneStaysEmpty)
{
    using R = TypeParam;
    NodeArrays<R> box;
    const Node<R> node{{R(0.02), R(0.04), 0}, R(0.02)};
    const Node<R> after = box.update(node, {8, 8, 8}, {0, R(-9.81), 0});
    EXPECT_EQ(after.m, node.m);
    EXPECT_NEAR(double(after.p.x), 1, 1e-6);
    EXPECT_NEAR(double(after.p.y), 2 - 9.81e-3, 1e-6);
    const Node<R> none = box.update(Node<R>{}, {8, 8, 8}, {0, R(-9.81), 0});
    EXPECT_EQ(length(none.p), 0);
    EXPECT_EQ(none.m, 0);
}

// A particle half-way between nodes but for a rounding leaves a corner node the cube of a weight of
// 1e-11: in float that times its mass is denormal, and its reciprocal infinite.
TYPED_TEST(GuardTest, ANodeThatHardlyHoldsAnythingMovesAtAFiniteSpeed)
{
    using R = TypeParam;
    NodeArrays<R> box;
    for (const R m :
         {std::numeric_limits<R>::denorm_min(), 5 * std::numeric_limits<R>::denorm_min(),
          std::numeric_limits<R>::min() / 8, std::numeric_limits<R>::min()}) {
        const Node<R> after = box.update({{0, 2 * m, -m}, m}, {8, 8, 8});
        EXPECT_EQ(after.p.x, 0);
        EXPECT_NEAR(double(after.p.y), 2, 1e-6);
        EXPECT_NEAR(double(after.p.z), -1, 1e-6);
    }
}

TYPED_TEST(GuardTest, WallsStopWhatRunsIntoThemOnAllSixSides)
{
    using R = TypeParam;
    NodeArrays<R> box;
    const Int3 size = box.lattice.size;
    const Node<R> node{{R(-0.5), R(-0.7), R(-0.9)}, R(1)};
    const Node<R> away{{R(0.5), R(0.7), R(0.9)}, R(1)};
    box.walls.friction = 0;
    const auto velocity = [&](const Node<R>& n, Int3 at) { return box.update(n, at).p; };
    EXPECT_EQ(velocity(node, {3, 8, 8}).x, 0);
    EXPECT_EQ(velocity(node, {0, 8, 8}).x, 0);
    EXPECT_NE(velocity(node, {4, 8, 8}).x, 0);
    EXPECT_EQ(velocity(node, {8, 3, 8}).y, 0);
    EXPECT_EQ(velocity(node, {8, 8, 3}).z, 0);
    EXPECT_EQ(velocity(away, {size.x - 4, 8, 8}).x, 0);
    EXPECT_NE(velocity(away, {size.x - 5, 8, 8}).x, 0);
    EXPECT_EQ(velocity(away, {8, size.y - 4, 8}).y, 0);
    EXPECT_EQ(velocity(away, {8, 8, size.z - 4}).z, 0);
    EXPECT_NE(velocity(away, {3, 8, 8}).x, 0);         // leaving is free
    EXPECT_EQ(length(velocity(node, {3, 3, 3})), 0);   // in a corner nothing is left
    EXPECT_EQ(velocity(node, {3, 8, 8}).y, node.p.y);  // and no friction without its coefficient
}

TYPED_TEST(GuardTest, WallsRubWithCoulombsLaw)
{
    using R = TypeParam;
    NodeArrays<R> box;  // friction 0.5
    const Vec3<R> sliding = box.update({{4, -2, 0}, 1}, {8, 3, 8}).p;
    EXPECT_NEAR(double(sliding.x), 3, 1e-6);
    EXPECT_EQ(sliding.y, 0);
    EXPECT_EQ(length(box.update({{R(0.9), -2, 0}, 1}, {8, 3, 8}).p), 0);
    box.walls.mode = ContactMode::sticky;
    EXPECT_EQ(length(box.update({{4, -2, 0}, 1}, {8, 3, 8}).p), 0);
}

TYPED_TEST(GuardTest, ANodeNeverOutrunsACellAndSaysSo)
{
    using R = TypeParam;
    NodeArrays<R> box;
    const R limit = box.lattice.dx / R(1e-3);
    EXPECT_NEAR(double(length(box.update({{3 * limit, -4 * limit, 0}, 1}, {8, 8, 8}).p)),
                double(limit), 1e-4);
    EXPECT_TRUE(box.clipped);
    box.update({{limit / 2, 0, 0}, 1}, {8, 8, 8});
    EXPECT_FALSE(box.clipped);
}

TYPED_TEST(GuardTest, AParticleBehindAWallComesBackAndStops)
{
    using R = TypeParam;
    NodeArrays<R> box;
    Particle<R> q{};
    q.x = {R(0.1), R(5), R(1)}, q.v = {-1, 1, 3};
    EXPECT_TRUE(confine(q, box.walls));
    EXPECT_EQ(q.x.x, box.lattice.dx * R(3));
    EXPECT_EQ(q.x.y, box.lattice.dx * R(16));
    EXPECT_EQ(q.x.z, R(1));
    EXPECT_EQ(q.v.x, 0);
    EXPECT_EQ(q.v.y, 0);
    EXPECT_EQ(q.v.z, 3);
    EXPECT_FALSE(confine(q, box.walls));
    q.x.y = R(1.6) + R(0.012), q.v.y = 1;  // on the wall within what its nodes may do
    EXPECT_FALSE(confine(q, box.walls));
    EXPECT_EQ(q.x.y, box.lattice.dx * R(16));
    EXPECT_EQ(q.v.y, 0);
    q.x.y = R(1.6) + R(0.013);
    EXPECT_TRUE(confine(q, box.walls));
    // Wherever it is confined to, its stencil stays within the lattice.
    box.walls = walls_on<R>(box.lattice, walls_inside(box.lattice, 2, ContactMode::slip, 0));
    for (const R far : {R(-1e6), R(1e6)}) {
        q.x = {far, far, far};
        confine(q, box.walls);
        const Int3 base = base_node(q.x, box.lattice.dx);
        EXPECT_TRUE(base.x >= 0 && base.y >= 0 && base.z >= 0);
        EXPECT_TRUE(base.x + 2 < box.lattice.size.x && base.y + 2 < box.lattice.size.y &&
                    base.z + 2 < box.lattice.size.z);
    }
}

// Nodes on and behind a face are held, wherever between two nodes it stands; one that is off a node
// by rounding, or by what six decimals leave out, stands on it.
TYPED_TEST(GuardTest, AWallHoldsTheNodesOnAndBehindItAndNoOther)
{
    using R = TypeParam;
    NodeArrays<R> box;
    const double dx = double(box.lattice.dx);
    const Node<R> node{{R(-0.5), R(-0.7), R(-0.9)}, R(1)}, up{{0, R(0.7), 0}, R(1)};
    struct {
        double min, max;  // of y, in cells
        int first, last;  // free nodes
    } const cases[] = {{3, 16, 4, 15},
                       {3.5, 15.5, 4, 15},
                       {3.01, 15.99, 4, 15},
                       {2.99, 16.01, 3, 16},
                       {3.99, 15.01, 4, 15},
                       {3 - 1e-6, 16 + 1e-6, 4, 15},
                       {3 + 1e-6, 16 - 1e-6, 4, 15}};
    for (const auto& c : cases) {
        box.options.min.y = dx * c.min, box.options.max.y = dx * c.max;
        box.walls = walls_on<R>(box.lattice, box.options);
        for (int y = 0; y < box.lattice.size.y; ++y) {
            EXPECT_EQ(box.update(node, {8, y, 8}).p.y == 0, y < c.first) << c.min << ' ' << y;
            EXPECT_EQ(box.update(up, {8, y, 8}).p.y == 0, y > c.last) << c.max << ' ' << y;
        }
    }
}

// A stencil at the wall also reaches free nodes, which may come down at a cell per substep: on a
// node's place with a weight of 1/8.
TYPED_TEST(GuardTest, AParticleSinksIntoAWallByAnEighthOfACellAtMostAndThatIsNoEscape)
{
    using R = TypeParam;
    Draw draw(3);
    const R dt = R(1e-3);
    double deepest = 0;
    for (int round = 0; round < 20000; ++round) {
        NodeArrays<R> box;
        box.walls.mode = ContactMode(draw.below(3));
        const R dx = box.lattice.dx, floor = box.walls.min.y, limit = dx / dt;
        Particle<R> q{};
        q.x = {R(draw.in(0.5, 0.9)), floor + dx * R(draw.below(4) ? draw.in(0, 2) : 0),
               R(draw.in(0.5, 0.9))};
        const double slant = draw.in(0, 1), speed = draw.in(0.5, 1.5);
        const Stencil<R> s = stencil(q.x, dx);
        gather(q, s, dx, [&](Int3 step) {
            const Vec3<double> way = Vec3<double>{0, -1, 0} + draw.vector(slant);
            return box.update({cast<R>(speed * double(limit) * way), 1}, s.base + step, {}, dt).p;
        });
        q.x = q.x + dt * q.v;
        deepest = std::fmax(deepest, double((floor - q.x.y) / dx));
        EXPECT_FALSE(confine(q, box.walls));
        EXPECT_GE(q.x.y, floor);
    }
    EXPECT_GT(deepest, 0.12);
    EXPECT_LT(deepest, 0.125 + either<R>(1e-5, 1e-13));
}

// The same of a wall between two nodes: as deep as the free ones weigh at the wall.
TYPED_TEST(GuardTest, IntoAWallBetweenNodesAParticleSinksAsDeepAsTheFreeOnesWeighAndNotDeeper)
{
    using R = TypeParam;
    const R dt = R(1e-3);
    for (const double behind : {0.0, 0.1, 0.3, 0.49, 0.51, 0.7, 0.9, 0.99}) {
        NodeArrays<R> box;
        const R dx = box.lattice.dx, limit = dx / dt;
        box.options.min.y += behind * double(dx);
        box.walls = walls_on<R>(box.lattice, box.options);
        double deepest = 0;
        for (int above = 0; above <= 100; ++above) {
            Particle<R> q{};
            q.x = {R(0.7), box.walls.min.y + R(0.01 * above) * dx, R(0.8)};
            const Stencil<R> s = stencil(q.x, dx);
            gather(q, s, dx, [&](Int3 step) {
                return box.update({{0, -limit, 0}, 1}, s.base + step, {}, dt).p;
            });
            q.x = q.x + dt * q.v;
            deepest = std::fmax(deepest, double((box.walls.min.y - q.x.y) / dx));
            EXPECT_FALSE(confine(q, box.walls)) << behind << ' ' << above;
            EXPECT_GE(q.x.y, box.walls.min.y);
        }
        EXPECT_NEAR(deepest, sinking(behind) - 0.001, either<R>(1e-5, 1e-13)) << behind;
        Particle<R> q{};
        q.x = {R(0.7), box.walls.min.y - R(sinking(behind) + 0.001) * dx, R(0.8)};
        EXPECT_TRUE(confine(q, box.walls)) << behind;
    }
}

TYPED_TEST(GuardTest, ANumberThatIsNoneIsRepairedInWhateverFieldItIsBorn)
{
    using R = TypeParam;
    Particle<R> sound{};
    sound.x = {1, 2, 3}, sound.v = {4, 5, 6}, sound.C = diagonal(R(2)), sound.e = isotropic(R(0.1));
    sound.k = R(0.5), sound.object = 3, sound.sides = 2;
    R Particle<R>::*const scalar = &Particle<R>::k;
    for (const R bad : {std::numeric_limits<R>::quiet_NaN(), std::numeric_limits<R>::infinity(),
                        -std::numeric_limits<R>::infinity()})
        for (int field = 0; field < 22; ++field) {
            Particle<R> q = sound;
            R* const fields[] = {&q.x.x,   &q.x.y,   &q.x.z,   &q.v.x,      &q.v.y,   &q.v.z,
                                 &q.C.a.x, &q.C.a.y, &q.C.a.z, &q.C.b.x,    &q.C.b.y, &q.C.b.z,
                                 &q.C.c.x, &q.C.c.y, &q.C.c.z, &q.e.xx,     &q.e.yy,  &q.e.zz,
                                 &q.e.xy,  &q.e.xz,  &q.e.yz,  &(q.*scalar)};
            *fields[field] = bad;
            EXPECT_TRUE(repair(q, sound)) << field;
            EXPECT_EQ(length(q.x - sound.x), 0);
            EXPECT_EQ(length(q.v) + size(q.C) + size(q.e) + std::abs(q.k), 0);
            EXPECT_EQ(q.object, 3);
            EXPECT_EQ(q.sides, 2u);
        }
    Particle<R> q = sound;
    EXPECT_FALSE(repair(q, {}));
    EXPECT_EQ(q.k, sound.k);
    q.C = diagonal(R(1e5)), q.e = isotropic(R(1e6)), q.v = {R(1e6), 0, 0};  // violent but numbers
    EXPECT_FALSE(repair(q, {}));
}

// A face at 0.3 m stands in float a little above: clay that rests there is between the walls.
TEST(Walls, ClayThatRestsOnAFaceIsBetweenTheWalls)
{
    const WallOptions options{{0.1, 0.1, 0.1}, {0.3, 0.3, 0.3}, ContactMode::sticky, 0};
    for (const double cells : {16, 128, 1024}) {
        const double at = double(0.3f), dx = 1 / cells;
        EXPECT_GT(at, 0.3);
        EXPECT_TRUE(between(options, {at, at, at}, dx));
        EXPECT_TRUE(between(options, {double(0.1f), 0.1, 0.2}, dx));
        EXPECT_FALSE(between(options, {0.2, 0.3 + 0.01 * dx, 0.2}, dx));
        EXPECT_FALSE(between(options, {0.2, 0.1 - 0.01 * dx, 0.2}, dx));
        EXPECT_FALSE(between(options, {0.2, NAN, 0.2}, dx));
    }
}

}  // namespace
}  // namespace knead
