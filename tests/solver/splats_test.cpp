// Gaussians that follow the clay, on every back end that is there.
#include <gtest/gtest.h>

#include <cmath>

#include "cuda/math/rotation.h"
#include "host/bench/ball.h"
#include "host/solver/reference.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/followers.h"
#include "tests/solver/same_bits.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
using Gaussians = std::vector<Gaussian<double>>;
constexpr double frame = 1.0 / 90, dx = 1.0 / 32;
constexpr Vec3<double> middle{0.5, 0.5, 0.5};

class Follow : public Following {};
INSTANTIATE_TEST_SUITE_P(Solver, Follow,
                         testing::Values(follower_float, follower_reference, follower_cuda),
                         name_of);
// Those that take edits.
class FollowEdits : public OnBothDevices {};
INSTANTIATE_TEST_SUITE_P(Solver, FollowEdits, testing::Values(false, true), device_of);

// A ball of radius r [m] around c, elastic where the yield stress is 0 [Pa], with a Gaussian at
// each of its particles.
Given ball_of(double r, Vec3<double> c, double young, double yield)
{
    Given s{};
    s.lattice = {{32, 32, 32}, dx};
    s.walls = walls_inside(s.lattice, 3, ContactMode::separate, 0.3);
    s.materials = {paper_clay(dx, 8)};
    Material<double>& m = s.materials[0];
    m.plasticity = yield > 0 ? Plasticity::von_mises : Plasticity::none;
    m.mu = young / 2.6, m.lambda = young * 0.3 / (1.3 * 0.4), m.yield = yield;
    for (int z = 0; z < 64; ++z)
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 64; ++x) {
                Particle<double> q{};
                q.x = dx / 2 * Vec3<double>{x + 0.5, y + 0.5, z + 0.5};
                if (length(q.x - c) >= r) continue;
                s.particles.push_back(q), s.gaussians.push_back(gaussian_at(q.x, 0));
            }
    return s;
}

double volume_ratio(const Particle<double>& p) { return std::sqrt(1 + determinant_excess(p.e)); }

struct Off {
    double mean = 0, max = 0;           // Gaussians from the particles they began at [cells]
    double volume = 0, max_volume = 0;  // det F from the particle's volume ratio
};
Off distance(const Simulator& solver)
{
    const auto g = solver.gaussians();
    const auto q = solver.particles();
    Off o;
    for (std::size_t i = 0; i < g.size(); ++i) {
        const double way = length(g[i].x - q[i].x) / dx;
        const double v = std::fabs(determinant(g[i].F) / volume_ratio(q[i]) - 1);
        o.mean += way / double(g.size()), o.max = std::fmax(o.max, way);
        o.volume += v / double(g.size()), o.max_volume = std::fmax(o.max_volume, v);
    }
    return o;
}

// Half of the Gaussians of so small a ball lie at its surface.
TEST_P(Follow, OfASpinningBallTheyTurnWithItAndKeepItsVolume)
{
    Given s = ball_of(0.15, middle, 1e6, 0);
    const double rate = 10;  // [rad/s]
    for (auto& p : s.particles) {
        p.v = cross(Vec3<double>{0, 0, rate}, p.x - middle);
        p.C = {{0, rate, 0}, {-rate, 0, 0}, {0, 0, 0}};
    }
    const auto solver = make(s);
    FrameStats stats;
    double time = 0;
    for (int f = 0; f < 30; ++f, time += frame) stats = solver->advance({}, frame);
    EXPECT_EQ(
        stats[Count::stranded] + stats[Count::splats_projected] + stats[Count::splats_repaired], 0);
    const Off o = distance(*solver);
    EXPECT_LT(o.max, 0.01) << "cells";
    EXPECT_LT(o.volume, 5e-4);
    EXPECT_LT(o.max_volume, 0.01);
    const Mat3<double> Q = rotation(turn_about(Vec3<double>{0, 0, 1}, rate * time));
    double turned = 0;
    for (const auto& g : solver->gaussians()) turned += size(g.F - Q) / double(s.gaussians.size());
    EXPECT_LT(turned, 0.02);
}

TEST_P(Follow, AtTheSurfaceOfABallThatFallsOnTheFloorTheyMoveWithIt)
{
    Given s = ball_of(0.12, {0.5, 0.25, 0.5}, 1e5, 0);
    s.gravity = {0, -9.81, 0};
    const auto solver = make(s);
    double lowest = 1;
    for (int f = 0; f < 24; ++f, solver->advance({}, frame))
        for (const auto& p : solver->particles()) lowest = std::fmin(lowest, volume_ratio(p));
    EXPECT_LT(lowest, 0.97) << "nothing was pressed";
    const Off o = distance(*solver);
    EXPECT_LT(o.mean, 0.02) << "cells";
    EXPECT_LT(o.max, 0.25) << "cells";
    EXPECT_LT(o.volume, 5e-3);
}

TEST_P(Follow, TotalDeformationGoesOnWhereTheElasticOneIsMappedBack)
{
    Given s = ball_of(0.12, middle, 1e6, 2e3);
    add_tools(s);
    const auto solver = make(s);
    for (int f = 0; f < 40; ++f) {
        const double t = 0.16 + f * frame;
        const auto at = [](double time) { return wrists(0.31 - std::fmin(time, 0.24), 0); };
        solver->advance({at(t), at(t + frame), {1, 1}}, frame);
    }
    double total = 0, elastic = 0, volume = 0;
    const auto g = solver->gaussians();
    const auto q = solver->particles();
    for (std::size_t i = 0; i < g.size(); ++i) {
        const Sym3<double> b = symmetric(g[i].F * transpose(g[i].F));
        total += size(deviator(b)) / double(g.size());
        elastic += size(deviator(q[i].e)) / double(g.size());
        volume += std::fabs(determinant(g[i].F) - 1) / double(g.size());
    }
    EXPECT_GT(total, 0.3);
    EXPECT_LT(elastic, 0.02);
    EXPECT_LT(volume, 0.003 * total);  // 0.0019 of it, less in shorter substeps
}

// As deep as a particle may be: that of the two tools which is looked for last. Some float above
// the ball, where no clay takes them out of the tools' way.
TEST(FollowReference, NoneStaysInATool)
{
    Given s = ball_of(0.12, middle - Vec3<double>{0, 0.12, 0}, 1e6, 2e3);
    add_tools(s);
    for (double x = 0.05; x < 0.085; x += 0.01)
        for (double z = -0.01; z < 0.015; z += 0.01)
            for (double side : {-1.0, 1.0})
                s.gaussians.push_back(gaussian_at(middle + Vec3<double>{side * x, 0.13, z}, 0));
    Reference solver(s);
    long projected = 0;
    for (int f = 0; f < 30; ++f) {
        const double t = 0.16 + f * frame;
        const auto at = [](double time) { return wrists(0.31 - std::fmin(time, 0.22), 0); };
        projected += solver.advance({at(t), at(t + frame), {1, 1}}, frame)[Count::splats_projected];
        double deepest = 0;
        for (const auto& g : solver.gaussians()) {
            const auto hit = deepest_contact(solver.colliders(), solver.acting(), g.x);
            deepest = std::fmax(deepest, -hit.phi);
        }
        EXPECT_LT(deepest, 1e-9) << "m";
    }
    EXPECT_GT(projected, 50);
}

// Within one frame the tools pass the places where these float, by more than their width.
TEST_P(Follow, WhatFloatsStaysInFrontOfASwiftTool)
{
    Given s = ball_of(0.05, middle - Vec3<double>{0, 0, 0.15}, 1e6, 0);
    for (double x = 0.2; x < 0.8; x += dx / 2)  // a GPU stores nodes around clay only
        for (double z = 0.3; z < 0.37; z += dx / 2) {
            Particle<double> q{};
            q.x = {x, 0.4, z}, s.particles.push_back(q);
        }
    add_tools(s);
    s.gaussians.clear();
    for (double side : {-1.0, 1.0})
        for (double y : {-0.02, 0.0, 0.02})
            s.gaussians.push_back(gaussian_at(middle + Vec3<double>{side * 0.2, y, 0}, 0));
    const auto solver = make(s);
    const FrameStats stats = solver->advance({wrists(0.3, 0), wrists(0.06, 0), {1, 1}}, frame);
    EXPECT_GE(stats[Count::splats_projected], 6);
    for (const auto& g : solver->gaussians()) EXPECT_LT(std::fabs(g.x.x - 0.5), 0.06);
}

TEST_P(Follow, FarFromClayTheyStayAndAreCounted)
{
    Given s = ball_of(0.1, middle, 1e6, 0);
    s.gravity = {0, -9.81, 0};
    const Vec3<double> far{0.15, 0.8, 0.2};
    s.gaussians = {gaussian_at(far, 0), gaussian_at(middle, 0)};
    const auto solver = make(s);
    const FrameStats stats = solver->advance({}, frame);
    EXPECT_EQ(stats[Count::stranded], stats.substeps);
    EXPECT_LT(length(solver->gaussians()[0].x - far), 1e-7);
    EXPECT_LT(solver->gaussians()[1].x.y, 0.5);
}

TEST_P(Follow, TheClayDoesNotFeelThem)
{
    Given s = ball_of(0.12, {0.5, 0.25, 0.5}, 1e5, 1e3);
    s.gravity = {0, -9.81, 0}, s.deterministic = true;
    Given bare = s;
    bare.gaussians.clear();
    const auto one = make(s), other = make(bare);
    for (int f = 0; f < 4; ++f) one->advance({}, frame), other->advance({}, frame);
    EXPECT_TRUE(same_bits(one->particles(), other->particles()));
    EXPECT_TRUE(other->gaussians().empty());
}

// --- still clay ----------------------------------------------------------------------------------

// A ball that flies into one that lies still.
Given met(RestMode mode)
{
    Given s = ball_of(0.1, {0.3125, 0.5, 0.5}, 1e6, 0);
    Given second = ball_of(0.1, {0.625, 0.5, 0.5}, 1e6, 0);
    for (auto& p : s.particles) p.v = {1, 0, 0};
    for (std::size_t i = 0; i < second.particles.size(); ++i) {
        s.particles.push_back(second.particles[i]);
        s.gaussians.push_back(second.gaussians[i]);
    }
    s.rest = {mode, 0.05, 1, 4.9, 4 * dx};
    return s;
}

TEST_P(FollowEdits, StillClayCarriesStillGaussiansAndThoseOfWokenClayGoWithIt)
{
    const Given s = met(RestMode::sleep);
    const auto solver = make(s);
    solver->advance({}, frame), solver->advance({}, frame);
    const std::size_t half = s.gaussians.size() / 2;
    const Gaussians before = solver->gaussians();
    for (std::size_t i = half; i < before.size(); ++i) {
        ASSERT_EQ(float(before[i].x.x), float(s.gaussians[i].x.x));
        ASSERT_EQ(determinant(before[i].F), 1);
    }
    long woken = 0;
    for (int f = 0; f < 20; ++f) woken += solver->advance({}, frame)[Count::woken];
    EXPECT_GT(woken, 0);
    const Off o = distance(*solver);
    EXPECT_LT(o.mean, 0.02) << "cells";
    EXPECT_LT(o.max, 0.3) << "cells";
    EXPECT_GT(solver->gaussians()[half].x.x, before[half].x.x + dx);
}

TEST_P(FollowEdits, OutsideOfTheBoxesOfTheLocalizedModeNoneMoves)
{
    Given s = met(RestMode::localized);
    add_tools(s);
    const auto solver = make(s);
    const auto at = [](double time) { return wrists(0.31 - std::fmin(time, 0.12), 0); };
    for (int f = 0; f < 8; ++f)
        solver->advance({at(0.02 + f * frame), at(0.02 + (f + 1) * frame), {0, 1}}, frame);
    const std::size_t half = s.gaussians.size() / 2;
    const Gaussians after = solver->gaussians();
    for (std::size_t i = 0; i < half; ++i)
        ASSERT_EQ(float(after[i].x.x), float(s.gaussians[i].x.x));
    double moved = 0;
    for (std::size_t i = half; i < after.size(); ++i)
        moved = std::fmax(moved, length(after[i].x - s.gaussians[i].x));
    EXPECT_GT(moved, 0.2 * dx);
}

// --- edits ---------------------------------------------------------------------------------------

Given pressed()
{
    Given s = ball_of(0.12, middle, 1e6, 2e3);
    add_tools(s);
    s.deterministic = true, s.threads = 2;
    return s;
}
void play(Simulator& solver, int from, int frames)
{
    const auto at = [](double time) { return wrists(0.31 - std::fmin(0.15 + time, 0.22), 0); };
    for (int f = from; f < from + frames; ++f)
        solver.advance({at(f * frame), at((f + 1) * frame), {1, 1}}, frame);
}
void expect_same(const Simulator& a, const Simulator& b)
{
    EXPECT_TRUE(same_bits(a.gaussians(), b.gaussians()));
    EXPECT_TRUE(same_bits(a.particles(), b.particles()));
}

TEST_P(FollowEdits, AttachedBetweenFramesTheyAreThoseOfASceneMadeSo)
{
    Given s = pressed();
    const Gaussians all = s.gaussians;
    s.gaussians.assign(all.begin(), all.begin() + 100);
    const auto edited = make(s);
    play(*edited, 0, 2);
    Given anew{edited->config(), {edited->particles(), edited->gaussians()}, s};
    std::vector<Vec3<double>> places;
    for (std::size_t i = 100; i < 400; ++i) {
        places.push_back(cast<double>(cast<float>(all[i].x)));
        anew.gaussians.push_back(gaussian_at(places.back(), 0));
    }
    edited->attach(0, places);
    const auto fresh = make(anew);
    expect_same(*edited, *fresh);
    play(*edited, 2, 3), play(*fresh, 2, 3);
    ASSERT_EQ(edited->gaussians().size(), 400u);
    expect_same(*edited, *fresh);
}

TEST_P(FollowEdits, TheyAreMovedAndRemovedWithTheirObject)
{
    const Given s = pressed();
    const auto solver = make(s);
    play(*solver, 0, 2);
    const Gaussians before = solver->gaussians();
    Material<double> m = s.materials[0];
    Particle<double> p{};
    p.x = {0.2, 0.2, 0.2};
    const int second = solver->add(m, {p});
    solver->attach(second, {p.x, {0.2, 0.22, 0.2}});
    const RigidMotion<double> motion{turn_about(Vec3<double>{0, 1, 0}, 0.3), {0.1, 0.05, -0.05}};
    solver->move(0, motion);
    const Gaussians moved = solver->gaussians();
    const Mat3<double> Q = rotation(motion.q);
    ASSERT_EQ(moved.size(), before.size() + 2);
    for (std::size_t i = 0; i < before.size(); ++i) {
        ASSERT_LT(length(moved[i].x - (motion.p + Q * before[i].x)), 2e-7);
        ASSERT_LT(size(moved[i].F - Q * before[i].F), 1e-6);
    }
    solver->remove(0);
    const Gaussians left = solver->gaussians();
    ASSERT_EQ(left.size(), 2u);
    EXPECT_EQ(left[0].object, second);
    EXPECT_FLOAT_EQ(float(left[1].x.y), 0.22f);
    solver->advance({wrists(0.4, 0), wrists(0.4, 0), {1, 1}}, frame);
    solver->remove(second);
    EXPECT_TRUE(solver->gaussians().empty());
    solver->advance({wrists(0.4, 0), wrists(0.4, 0), {1, 1}}, frame);
}

TEST_P(FollowEdits, ASnapshotAndASavedStateBringThemBackToTheBit)
{
    const auto solver = make(pressed());
    play(*solver, 0, 2);
    const auto snapshot = solver->snapshot();
    const SavedState saved = solver->save();
    ASSERT_FALSE(saved.contents.gaussians.empty());
    play(*solver, 2, 3);
    const Gaussians wanted = solver->gaussians();
    solver->attach(0, {middle});
    solver->restore(*snapshot);
    play(*solver, 2, 3);
    EXPECT_TRUE(same_bits(solver->gaussians(), wanted));
    Given other = pressed();
    other.gaussians.clear();
    const auto loaded = make(other);
    loaded->load(saved);
    play(*loaded, 2, 3);
    EXPECT_TRUE(same_bits(loaded->gaussians(), wanted));
}

TEST_P(FollowEdits, WhatCannotBeIsRefusedAndNothingChanges)
{
    const auto solver = make(pressed());
    const Gaussians before = solver->gaussians();
    const auto refused = [&](int object, Vec3<double> x) {
        try {
            solver->attach(object, {middle, x});
        } catch (const std::invalid_argument& e) {
            return std::string(e.what());
        }
        return std::string("accepted");
    };
    EXPECT_EQ(refused(7, middle), "there is no object 7");
    EXPECT_EQ(refused(0, {0.5, NAN, 0.5}), "a Gaussian with a number that is not finite");
    EXPECT_EQ(refused(0, {0.5, 0.01, 0.5}),
              "a Gaussian at (0.500000, 0.010000, 0.500000) m would lie behind a wall");
    // In a corner, where its clay does not come.
    Given corner = pressed();
    corner.gaussians = {gaussian_at(Vec3<double>{0.86, 0.86, 0.86}, 0)};
    const auto held = make(corner);
    EXPECT_THROW(held->move(0, {{1, 0, 0, 0}, {0.1, 0, 0}}), std::invalid_argument);
    EXPECT_FLOAT_EQ(float(held->gaussians()[0].x.x), 0.86f);
    Given wrong = pressed();
    wrong.gaussians[5].object = 2;
    EXPECT_THROW(make(wrong), std::invalid_argument);
    wrong.gaussians[5].object = 0, wrong.gaussians[5].F.a.x = NAN;
    EXPECT_THROW(make(wrong), std::invalid_argument);
    EXPECT_TRUE(same_bits(solver->gaussians(), before));
}

TEST(FollowOnTheCpu, TheBitsAreTheSameForAnyNumberOfThreads)
{
    Given s = pressed();
    Gaussians wanted;
    for (const int threads : {1, 2, 5}) {
        s.threads = threads;
        const auto solver = cpu_solver(s);
        play(*solver, 0, 6);
        if (threads == 1) wanted = solver->gaussians();
        EXPECT_TRUE(same_bits(solver->gaussians(), wanted)) << threads;
    }
}

}  // namespace
}  // namespace knead
