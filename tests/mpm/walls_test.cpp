// Walls that stand on a plane of nodes: a node before the face and its image behind it obey it
// together.
#include <algorithm>
#include <cmath>

#include "cuda/mpm/g2p.h"
#include "cuda/mpm/grid.h"
#include "cuda/mpm/p2g.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

const ContactMode modes[] = {ContactMode::sticky, ContactMode::slip, ContactMode::separate};
const Lattice<double> lattice{{16, 20, 24}, 0.1};

Walls<double> walls_of(ContactMode mode, double friction)
{
    return walls_on<double>(lattice, walls_inside(lattice, 3, mode, friction));
}

// Faces that stand on nodes, by bits: of each axis the low one, then the high one.
int on_nodes(const WallOptions& options)
{
    const Walls<double> w = walls_on<double>(lattice, options);
    int bits = 0, bit = 1;
    for (const int node :
         {w.low_face.x, w.high_face.x, w.low_face.y, w.high_face.y, w.low_face.z, w.high_face.z}) {
        bits |= node != no_node ? bit : 0;
        bit *= 2;
    }
    return bits;
}

double energy(const Node<double>& n) { return n.m * dot(n.p, n.p) / 2; }

// The impulse is the same on both, no more than the face may give, and makes no energy; the clay
// between them does not go through the face.
TEST(Walls, OnANodeAndItsImageActWithOneImpulseWithinTheLawOfContact)
{
    Draw draw(11);
    long held = 0, slid = 0, left_free = 0;
    for (int round = 0; round < 30000; ++round) {
        const ContactMode mode = modes[round % 3];
        const Walls<double> walls = walls_of(mode, draw.in(0, 1));
        const Vec3<double> axis = round % 2 ? Vec3<double>{0, 1, 0} : Vec3<double>{0, 0, -1};
        const Node<double> before{draw.vector(1), std::exp(draw.in(-20, 0))};
        const Node<double> mirror_node{draw.vector(1), std::exp(draw.in(-20, 0))};
        Node<double> a = before, b = mirror_node;
        apply_wall(a, b, true, axis, walls, false);
        const Vec3<double> of_a = a.m * (a.p - before.p), of_b = b.m * (b.p - mirror_node.p);
        EXPECT_LT(length(of_a - of_b), 1e-14 * std::fmax(a.m, b.m));
        const Vec3<double> J = a.m < b.m ? of_a : of_b;  // with fewer digits lost
        EXPECT_LE(energy(a) + energy(b), (energy(before) + energy(mirror_node)) * (1 + 1e-14));
        const Vec3<double> mean = 0.5 * (a.p + b.p), was = 0.5 * (before.p + mirror_node.p);
        const double push = dot(J, axis), rubs = length(J - push * axis);
        if (mode == ContactMode::slip) {
            EXPECT_NEAR(dot(mean, axis), 0, 1e-14);
            EXPECT_LT(rubs, 1e-15 * std::fmin(a.m, b.m) + 1e-16 * length(J));
        } else if (dot(was, axis) >= 0) {
            EXPECT_EQ(length(J), 0);
            ++left_free;
        } else {
            EXPECT_NEAR(dot(mean, axis), 0, 1e-14);
            EXPECT_GT(push, 0);
            const double speed = length(mean);
            if (mode == ContactMode::sticky) {
                EXPECT_LT(speed, 1e-14);
            }
            if (mode != ContactMode::separate) continue;
            EXPECT_LE(rubs, walls.friction * push + 1e-14 * std::fmin(a.m, b.m));
            if (speed > 1e-9) {
                EXPECT_NEAR(rubs, walls.friction * push, 1e-14 * std::fmin(a.m, b.m));
            }
            ++(speed > 1e-9 ? slid : held);
        }
    }
    EXPECT_GT(held, 300);
    EXPECT_GT(slid, 1000);
    EXPECT_GT(left_free, 1000);
}

// Every node is updated once: with its images, or as an image of a node that holds mass.
TEST(Walls, EachNodeIsUpdatedOnceWhateverHoldsMass)
{
    Draw draw(5);
    for (const int nodes : {2, 3, 6}) {  // the last leave 2 to 10 free nodes along an axis
        const Walls<double> walls =
            walls_on<double>(lattice, walls_inside(lattice, nodes, ContactMode::slip, 0));
        for (int round = 0; round < 20; ++round) {
            std::vector<double> mass(std::size_t(lattice.node_count()));
            for (double& m : mass) m = draw.below(3) ? draw.in(0, 1) : 0;
            const auto at = [&](Int3 n) { return std::size_t(lattice.index(n)); };
            std::vector<int> times(mass.size(), 0);
            long mirrors = 0, most = 0;
            for (int i = 0; i < lattice.node_count(); ++i) {
                const Int3 n = lattice.node_at(i);
                if (!(mass[at(n)] > 0)) continue;
                const auto how = mirror_set(
                    n, walls, [&](Int3 mirror_offset) { return mass[at(n + mirror_offset)]; });
                if (how.is_mirror) continue;
                const int count = mirror_count(how.mirror_offset);
                for (int k = 0; k < count; ++k) ++times[at(mirror_node(n, how.mirror_offset, k))];
                mirrors += count - 1, most = std::max<long>(most, count);
            }
            for (std::size_t i = 0; i < mass.size(); ++i)
                if (mass[i] > 0) {
                    ASSERT_EQ(times[i], 1) << i;
                }
            EXPECT_GT(mirrors, 100);
            EXPECT_EQ(most, 8);
        }
    }
}

// Faces between nodes, and those of a box of one free node, have no images.
TEST(Walls, OnlyFacesThatStandOnNodesHaveImages)
{
    WallOptions options = walls_inside(lattice, 3, ContactMode::slip, 0);
    EXPECT_EQ(on_nodes(options), 63);
    options.min.y += 0.01, options.max.z -= 0.05;
    EXPECT_EQ(on_nodes(options), 63 - 4 - 32);
    options.min.y += 1e-6 - 0.01;
    EXPECT_EQ(on_nodes(options), 63 - 32);
    options.max.x = options.min.x + 0.2;
    EXPECT_EQ(on_nodes(options), 63 - 32 - 3);
}

// Masses of the nodes of a column, from the one behind the face on, under a half space of clay of
// two layers a cell whose surface is `gap` cells above the face.
std::vector<double> column_under(double gap)
{
    std::vector<double> mass(8);
    for (int layer = 0; layer < 12; ++layer) {
        const double y = 1 + gap + 0.25 + 0.5 * layer;  // in cells from the node behind the face
        const Stencil<double> s = stencil(Vec3<double>{5, y, 5}, 1.0);
        for (int j = 0; j < 3; ++j)
            if (const int n = s.base.y + j; n < 8) mass[std::size_t(n)] += s.w[j].y;
    }
    return mass;
}

// Flush clay touches; of clay that hangs higher the gap is seen within a sixth of a cell, less the
// tenth that counts as touching.  (18b)
TEST(Walls, TheGapUnderClayIsSeenByTwoMasses)
{
    for (const double gap : {0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 0.8}) {
        const std::vector<double> m = column_under(gap);
        const double seen = gap_before_face(m[1], m[2]);
        if (gap <= 0.05) {
            EXPECT_EQ(seen, 0) << gap;
        }
        EXPECT_NEAR(seen, std::fmax(gap - 0.1, 0), gap < 0.4 ? 0.05 : 0.3) << gap;
        EXPECT_LE(seen, gap);
    }
    EXPECT_NEAR(column_under(0)[1] / column_under(0)[2], 0.508, 0.001);
    EXPECT_NEAR(column_under(0.3)[1] / column_under(0.3)[2], 0.30, 0.005);
    EXPECT_EQ(gap_before_face(0.0, 0.0), 0);
    EXPECT_EQ(gap_before_face(1.0, 0.0), 0);
}

// Clay over a gap comes down by as much in a substep, and is stopped from there on; along the wall
// it is rubbed by no more than what the wall stops.
TEST(Walls, ClayOverAGapMayComeDownByAsMuch)
{
    Draw draw(17);
    constexpr double dt = 1e-3, dx = 0.1;
    long stops = 0;
    for (int round = 0; round < 3000; ++round) {
        const ContactMode mode = modes[round % 3];
        const Walls<double> walls = walls_of(mode, draw.in(0, 1));
        const double gap = draw.in(0.01, 0.6), nearer = gap * dx / dt;
        const Vec3<double> axis{0, 1, 0};
        Node<double> a{(dx / dt) * draw.vector(1), draw.in(0.1, 1)},
            b{(dx / dt) * draw.vector(1), 1};
        const Node<double> before = a, mirror_node = b;
        apply_wall(a, b, true, axis, walls, false, nearer, dt);
        const Vec3<double> was = 0.5 * (before.p + mirror_node.p), mean = 0.5 * (a.p + b.p);
        const Vec3<double> lost = a.m * (a.p - before.p) - b.m * (b.p - mirror_node.p);
        EXPECT_LT(length(lost), 1e-12 * dx / dt);  // one impulse on both
        if (was.y >= -nearer) {
            EXPECT_LT(length(mean - was), 1e-12 * dx / dt);
            continue;
        }
        ++stops;
        EXPECT_NEAR(mean.y, -nearer, 1e-12 * dx / dt);
        if (mode == ContactMode::separate) {
            const Vec3<double> along{was.x - mean.x, 0, was.z - mean.z};
            EXPECT_LE(length(along), walls.friction * (mean.y - was.y) * (1 + 1e-9));
        }
    }
    EXPECT_GT(stops, 300);
}

// A tool that leads the node before a face holds its image back only from what is nearer.
TEST(Walls, ALedNodeLetsItsImageComeAsNearAsTheGap)
{
    const Walls<double> walls = walls_of(ContactMode::separate, 0.3);
    for (const double down : {0.05, 0.3, 2.0}) {
        Node<double> a{{0.1, -down, 0}, 1}, b{{0.2, -down, 0}, 0.5};
        apply_wall(a, b, true, {0, 1, 0}, walls, true, 0.4);
        EXPECT_EQ(a.p.y, -down);
        EXPECT_NEAR((a.p.y + b.p.y) / 2, -std::fmin(down, 0.4), 1e-15);
    }
}

// Whatever the nodes do, of up to a cell per substep: clay before the face stays before it.
TEST(Walls, AParticleBeforeAFaceOnNodesDoesNotSinkIntoIt)
{
    Draw draw(3);
    constexpr double dt = 1e-3, dx = 0.1;
    double lowest = 1;
    for (int round = 0; round < 30000; ++round) {
        const Walls<double> walls = walls_of(modes[round % 3], draw.in(0, 1));
        Particle<double> q{};
        q.x = {0.75, walls.min.y + dx * draw.in(0, 1.49), 0.85};
        Node<double> column[4];  // from the image on
        for (Node<double>& n : column)
            n = {{0, draw.in(-1, 1) * dx / dt, 0}, std::exp(draw.in(-5, 0))};
        apply_wall(column[2], column[0], true, {0, 1, 0}, walls, round % 5 == 0);
        column[1].p = apply_walls(column[1].p, {8, 3, 8}, lattice, walls);
        gather(q, stencil(q.x, dx), dx, [&](Int3 step) {
            const int base = base_node(q.x, dx).y;
            return column[base + step.y - 2].p;
        });
        lowest = std::fmin(lowest, (q.x.y + dt * q.v.y - walls.min.y) / dx);
    }
    EXPECT_GE(lowest, -1e-12);
    EXPECT_LT(lowest, 1e-3);
}

}  // namespace
}  // namespace knead
