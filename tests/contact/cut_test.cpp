// A blade thinner than a cell parts clay for good.
#include <gtest/gtest.h>

#include <cmath>

#include "host/hands/hands.h"
#include "host/solver/audit.h"
#include "host/solver/editable_simulator.h"
#include "host/solver/pieces.h"
#include "host/solver/reference.h"
#include "tests/sanitized.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
constexpr int nodes = 32;
constexpr double dx = 1.0 / nodes;

// A block 10 cells wide in z, `cells` in x, and 5 high, on the floor, with a knife above it.
Setup block(bool blade, int cells = 10)
{
    Setup s;
    s.lattice = {{nodes, nodes, nodes}, dx};
    s.walls = walls_inside(s.lattice, 3, ContactMode::separate, 0.4);
    s.gravity = {0, -9.81, 0};
    Material<double> m{};
    m.elasticity = Elasticity::neo_hookean, m.plasticity = Plasticity::von_mises;
    m.density = 1000, m.mu = 8e4, m.lambda = 1.2e5, m.yield = 8e3;
    m.volume = dx * dx * dx / 8, m.mass = m.volume * m.density;
    s.materials = {m};
    for (int z = 0; z < 20; ++z)
        for (int y = 0; y < 10; ++y)
            for (int x = 0; x < 2 * cells; ++x) {
                Particle<double> q{};
                q.x = dx * Vec3<double>{16 + (x + 0.5) / 2 - cells / 2.0, 3 + (y + 0.5) / 2,
                                        11 + (z + 0.5) / 2};
                s.particles.push_back(q);
            }
    // A knife 2 mm thick: a triangle of spheres in the plane x = 0 of its joint.
    const Vec3<float> corner[3] = {{0, 0, -0.6f}, {0, 0, 0.6f}, {0, 0.9f, 0}};
    for (const Vec3<float>& c : corner) {
        Binding<float> b{};
        b.weight[0] = 1, b.offset[0] = c, b.radius = 1e-3f;
        s.rig.spheres.push_back(b);
    }
    s.rig.primitives = {{3, {0, 1, 2}, 0}};
    s.tools = {{ContactMode::separate, 0.1, blade, true}};
    return s;
}

// Draws the knife down through the block, up again, and waits `rest` seconds; `turn` is about the
// vertical. Returns how often a node had to be slowed.
long stroke(Simulator& solver, double rest, double x, Quat<double> turn = {1, 0, 0, 0})
{
    const double frame = 1.0 / 60;
    Motion motion;
    motion.from.assign(2 * joint_count, {turn, {x, 0.45, 0.5}});
    motion.to = motion.from;
    long clipped = 0;
    const auto move = [&](double to) {
        motion.from[0] = motion.to[0];
        motion.to[0].p.y = to;
        clipped += solver.advance(motion, frame)[Count::clipped];
    };
    for (int f = 1; f <= 30; ++f) move(0.45 - 0.4 * f / 30);
    for (int f = 1; f <= 15; ++f) move(0.05 + 0.6 * f / 15);
    for (int f = 0; f * frame < rest; ++f) move(0.65);
    return clipped;
}

std::vector<int> sizes(const std::vector<Particle<double>>& q, const Lattice<double>& lattice)
{
    std::vector<int> piece;
    std::vector<int> size(std::size_t(pieces(q, lattice, piece)), 0);
    for (int p : piece) ++size[std::size_t(p)];
    return size;
}

void expect_two_pieces(const Given& s, std::unique_ptr<Simulator> solver)
{
    const int count = int(s.particles.size());
    stroke(*solver, sanitized ? 0.1 : 1.0, 0.5);
    const auto q = solver->particles();
    const auto size = sizes(q, s.lattice);
    ASSERT_EQ(size.size(), 2u);
    EXPECT_GT(size[1], count * 2 / 5);
    EXPECT_EQ(size[0] + size[1], count);
    double kinetic = 0;
    for (const auto& p : q) kinetic = std::fmax(kinetic, length(p.v));
    EXPECT_TRUE(sanitized || kinetic < 0.05) << kinetic;  // m/s: they lie still
}

TEST(Cut, AKnifeStrokeLeavesTwoPiecesThatStayTwoThroughASecondOfRest)
{
    const Given s = block(true);
    expect_two_pieces(s, cpu_solver(s));
}

TEST(Cut, AKnifeStrokeOnADeviceLeavesTwoPiecesToo)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    Given s = block(true);
    expect_two_pieces(s, gpu_solver(s, 0));
    s.deterministic = true;
    expect_two_pieces(s, gpu_solver(s, 0));
}

void expect_gaussians_with_their_pieces(const Given& s, std::unique_ptr<Simulator> solver)
{
    stroke(*solver, 0.5, 0.5);
    const auto q = solver->particles();
    const auto g = solver->gaussians();
    ASSERT_EQ(g.size(), q.size());
    long labelled = 0, other = 0, lost = 0, across = 0;
    for (std::size_t i = 0; i < g.size(); ++i) {
        labelled += g[i].sides != uncut, other += g[i].sides != q[i].sides;
        lost += length(g[i].x - q[i].x) > dx;
        across += (g[i].x.x < 0.5) != (s.particles[i].x.x < 0.5);
    }
    EXPECT_GT(labelled, long(q.size()) / 2);
    EXPECT_LT(other, long(q.size()) / 200);
    EXPECT_LT(lost, long(q.size()) / 200);
    EXPECT_LT(across, long(q.size()) / 100);
}

TEST(Cut, GaussiansStayWithThePieceThatTheyWereAttachedTo)
{
    Given s = block(true);
    for (const auto& p : s.particles) s.gaussians.push_back(gaussian_at(p.x, 0));
    expect_gaussians_with_their_pieces(s, cpu_solver(s));
    if (gpu_present()) expect_gaussians_with_their_pieces(s, gpu_solver(s, 0));
}

TEST(Cut, GaussiansAttachedToCutClayTakeItsLabels)
{
    Given s = block(true);
    const auto solver = cpu_solver(s);
    stroke(*solver, 0.2, 0.5);
    const auto q = solver->particles();
    std::vector<Vec3<double>> places;
    for (const auto& p : q) places.push_back(p.x);
    solver->attach(0, places);
    const auto g = solver->gaussians();
    ASSERT_EQ(g.size(), q.size());
    long labelled = 0;
    for (std::size_t i = 0; i < g.size(); ++i) {
        EXPECT_EQ(g[i].sides, q[i].sides);
        labelled += g[i].sides != uncut;
    }
    EXPECT_GT(labelled, long(q.size()) / 2);
}

TEST(Cut, PiecesPulledApartMoveFreely)
{
    Given s = block(true);
    s.gravity = {0, 0, 0};
    auto solver = cpu_solver(s);
    stroke(*solver, 0, 0.5);
    Given after = s;
    after.particles = solver->particles();
    double left = 0, right = 0;
    for (auto& p : after.particles) p.v = {p.x.x < 0.5 ? -0.5 : 0.5, 0, 0}, p.C = {};
    after.rig = {}, after.tools = {{ContactMode::separate, 0, true, true}};
    solver = cpu_solver(after);
    Motion still;
    still.from.assign(2 * joint_count, {{1, 0, 0, 0}, {0, 0, 0}}), still.to = still.from;
    solver->advance(still, 0.02);
    for (const auto& p : solver->particles()) (p.x.x < 0.5 ? left : right) += p.v.x;
    const double half = double(s.particles.size()) / 2;
    EXPECT_NEAR(left / half, -0.5, 0.01);
    EXPECT_NEAR(right / half, 0.5, 0.01);
}

// The faces of the first cut still touch when the second is made: it is not forgotten for that.
TEST(Cut, ASecondStrokeBesideTheFirstLeavesThreePieces)
{
    Given s = block(true, 20);
    const auto solver = cpu_solver(s);
    const int count = int(s.particles.size());
    stroke(*solver, 0.2, 0.5);
    ASSERT_EQ(sizes(solver->particles(), s.lattice).size(), 2u);
    stroke(*solver, 0.5, 0.5 - 5 * dx);
    const auto size = sizes(solver->particles(), s.lattice);
    ASSERT_EQ(size.size(), 3u);
    EXPECT_NEAR(size[0], count / 2, count / 20);
    EXPECT_NEAR(size[1], count / 4, count / 20);
    EXPECT_NEAR(size[2], count / 4, count / 20);
}

TEST(Cut, AStrokeAcrossTwoHalvesDrawnApartLeavesFourPieces)
{
    const Given s = block(true);
    auto solver = cpu_solver(s);
    const int count = int(s.particles.size());
    stroke(*solver, 0, 0.5);
    Given apart = s;
    apart.particles = solver->particles();
    for (auto& p : apart.particles) p.x.x += p.x.x < 0.5 ? -4 * dx : 4 * dx, p.v = {}, p.C = {};
    solver = cpu_solver(apart);
    const double half_turn = std::sqrt(0.5);
    stroke(*solver, 0.5, 0.5, {half_turn, 0, half_turn, 0});
    const auto size = sizes(solver->particles(), s.lattice);
    ASSERT_EQ(size.size(), 4u);
    for (const int part : size) EXPECT_NEAR(part, count / 4, count / 20);
}

// A knife narrower than the block leaves uncut clay at both ends of the cut. It, and the clay on
// either side, are strained alike: neighbours whose pressures cancel each other at the nodes would
// show here.
TEST(Cut, AStrokeStrainsTheClayLittleMoreThanItsWeight)
{
    Given s = block(true);
    Material<double>& m = s.materials[0];
    if (!sanitized) m.mu = 3.85e5, m.lambda = 5.77e5;  // stiff: E = 1 MPa
    m.yield = 1e5;
    for (Binding<float>& b : s.rig.spheres) b.offset[0].z *= 0.15f;
    const auto solver = cpu_solver(s);
    s.rig = {}, s.tools = {};
    const auto left_alone = cpu_solver(s);
    EXPECT_EQ(stroke(*solver, 0.1, 0.5), 0);
    Motion still;
    still.from.assign(2 * joint_count, {{1, 0, 0, 0}, {0, 0, 0}}), still.to = still.from;
    for (int f = 0; f < 51; ++f) left_alone->advance(still, 1.0 / 60);
    const auto elastic = [&](const Simulator& of) {
        return audit(of.particles(), s.materials, dx).elastic;
    };
    EXPECT_LT(elastic(*solver), 2 * elastic(*left_alone));
    for (const auto& p : solver->particles())
        ASSERT_NEAR(log_volume_ratio(p, m), 0, 0.1) << p.x.x << " " << p.x.y << " " << p.x.z;
}

TEST(Cut, WithoutTheTwoSidedTreatmentTheLatticeHealsTheCut)
{
    const Given s = block(false);
    const auto solver = cpu_solver(s);
    stroke(*solver, 0.2, 0.5);
    EXPECT_EQ(sizes(solver->particles(), s.lattice).size(), 1u);
}

TEST(Cut, TheTwoHalvesPressedTogetherKeepTheirMomentumAndDoNotMix)
{
    Given s = block(true);
    s.gravity = {0, 0, 0};
    std::unique_ptr<Simulator> solver = std::make_unique<Reference>(s);
    stroke(*solver, 0, 0.5);
    Given after = s;
    after.particles = solver->particles();
    for (auto& p : after.particles)
        p.x.y += 0.2, p.v = {p.x.x < 0.5 ? 1.0 : -0.5, 0, 0}, p.C = {};  // off the floor
    const auto before = after.particles;
    after.rig = {};
    solver = std::make_unique<Reference>(after);
    Motion still;
    still.from.assign(2 * joint_count, {{1, 0, 0, 0}, {0, 0, 0}}), still.to = still.from;
    solver->advance(still, 0.03);
    double momentum = 0, was = 0, scale = 0;
    int crossed = 0;
    const auto q = solver->particles();
    double lowest_right = 1, highest_left = 0;
    for (std::size_t i = 0; i < q.size(); ++i) {
        momentum += q[i].v.x, was += before[i].v.x, scale += std::fabs(before[i].v.x);
        if (before[i].x.x < 0.5) highest_left = std::fmax(highest_left, q[i].x.x);
        if (before[i].x.x > 0.5) lowest_right = std::fmin(lowest_right, q[i].x.x);
    }
    for (std::size_t i = 0; i < q.size(); ++i)
        crossed += before[i].x.x < 0.5 ? q[i].x.x > lowest_right + dx / 2
                                       : q[i].x.x < highest_left - dx / 2;
    EXPECT_NEAR(momentum, was, 1e-9 * scale);
    EXPECT_EQ(crossed, 0);
}

}  // namespace
}  // namespace knead
