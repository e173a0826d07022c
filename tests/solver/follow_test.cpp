// When Gaussians follow the clay: not in every substep, but between frames none is behind.
#include <gtest/gtest.h>

#include <cmath>

#include "cuda/math/rotation.h"
#include "host/bench/ball.h"
#include "host/solver/reference.h"
#include "tests/solver/followers.h"
#include "tests/solver/same_bits.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
constexpr double dx = 1.0 / 32, dt = 2e-4;
constexpr Vec3<double> middle{0.5, 0.5, 0.5};

class FollowInTime : public Following {};
INSTANTIATE_TEST_SUITE_P(Solver, FollowInTime,
                         testing::Values(follower_float, follower_reference, follower_cuda),
                         name_of);

// An elastic ball that flies and turns, with a Gaussian at each of its particles, in substeps of
// the same length.
Given flying(Vec3<double> v, double rate)
{
    Given s = ball(32);
    s.gravity = {0, 0, 0}, s.materials[0].plasticity = Plasticity::none, s.step.fixed = dt;
    std::erase_if(s.particles, [](const auto& p) { return length(p.x - middle) > 0.15; });
    for (Particle<double>& p : s.particles) {
        p.v = v + cross(Vec3<double>{0, 0, rate}, p.x - middle);
        p.C = {{0, rate, 0}, {-rate, 0, 0}, {0, 0, 0}};
        s.gaussians.push_back(gaussian_at(p.x, 0));
    }
    return s;
}

// The farthest from where a rigid motion has brought them by then [cells]; of F.
struct Off {
    double x = 0, F = 0;
};
Off distance(const Given& s, const Simulator& solver, Vec3<double> way, double angle, double within)
{
    const Mat3<double> Q = rotation(turn_about(Vec3<double>{0, 0, 1}, angle));
    const auto all = solver.gaussians();
    Off most;
    for (std::size_t i = 0; i < all.size(); ++i) {
        const Vec3<double> r = s.gaussians[i].x - middle;
        if (length(r) > within) continue;
        most.x = std::fmax(most.x, length(all[i].x - (middle + way + Q * r)) / dx);
        most.F = std::fmax(most.F, size(all[i].F - Q));
    }
    return most;
}

// A substep's way is 0.0064 cells: who has missed one, or was moved by one too many, shows.
TEST_P(FollowInTime, AtTheEndOfAnyFrameTheyHaveFlownForAllOfIt)
{
    const Vec3<double> v{0.8, -0.5, 0.3};
    const Given s = flying(v, 0);
    const auto solver = make(s);
    double time = 0;
    for (int n = 1; n <= 2 * follow_every + 2; ++n) {
        const FrameStats stats = solver->advance({}, n * dt);
        time += n * dt;
        EXPECT_EQ(stats.substeps, n);
        EXPECT_EQ(stats[Count::stranded], 0);
        const Off o = distance(s, *solver, time * v, 0, 1);
        EXPECT_LT(o.x, 1e-4) << n << " substeps: cells";
        EXPECT_LT(o.F, 1e-3) << n;
    }
}

// Inside, where the spin has not pulled the ball apart yet: by then its particles are off by 3.6e-4
// cells themselves. A substep's way is 0.0077.
TEST_P(FollowInTime, AtTheEndOfAnyFrameTheyHaveTurnedForAllOfIt)
{
    const double rate = 20;
    for (int n = 1; n <= 2 * follow_every + 1; ++n) {
        const Given s = flying({0, 0, 0}, rate);
        const auto solver = make(s);
        EXPECT_EQ(solver->advance({}, n * dt).substeps, n);
        const Off o = distance(s, *solver, {}, rate * n * dt, 0.06);
        EXPECT_LT(o.x, 5e-4) << n << " substeps: cells";
        EXPECT_LT(o.F, 4e-4) << n;
    }
}

TEST_P(FollowInTime, AFrameOfNoLengthLeavesThemAsTheyAre)
{
    const Given s = flying({0.8, -0.5, 0.3}, 5);
    const auto solver = make(s);
    solver->advance({}, 3 * dt);
    const auto before = solver->gaussians();
    EXPECT_EQ(solver->advance({}, 0).substeps, 0);
    EXPECT_TRUE(same_bits(solver->gaussians(), before));
}

// A device is looked at every 20 ms only: there the frame is as long as that takes, or not cut.
TEST_P(FollowInTime, WhereAFrameIsCutTheyHaveComeAsFarAsTheClay)
{
    const Vec3<double> v{0.8, -0.5, 0.3};
    for (int cut = 1; cut <= follow_every + 1; ++cut) {
        const Given s = flying(v, 0);
        const auto solver = make(s);
        solver->set_stop_check([&](const FrameProgress& p) { return p.substeps >= cut; });
        const FrameStats stats = solver->advance({}, 40 * dt);
        const double time = stats.cut ? stats.reached : 40 * dt;
        if (!GetParam().device) {
            EXPECT_EQ(stats.substeps, cut);
        }
        EXPECT_LT(distance(s, *solver, time * v, 0, 1).x, 3e-4) << cut << ": cells";
    }
}

// A thin finger crosses half of the ball at 10 m/s, by half of its radius a substep. None of them
// is left in it, and of those that lay in its way none comes behind it whose particle does not.
TEST(FollowReference, AFastFingerTakesThemAlong)
{
    Given s = flying({0, 0, 0}, 0);
    const double radius = 0.02, speed = 10, way = 0.2, duration = way / speed;
    s.step.fixed = 0, s.materials[0].plasticity = Plasticity::von_mises;
    s.materials[0].yield = 2e3;
    add_tools(s);
    for (auto& b : s.rig.spheres) b.radius = float(radius);
    const auto at = [](double apart) { return wrists(apart, 0); };
    Reference solver(s);
    const int frames = 10;
    for (int f = 0; f < frames; ++f) {
        const auto apart = [&](int n) { return 0.2 - way * n / frames; };
        solver.advance({at(apart(f)), at(apart(f + 1)), {0, 1}}, duration / frames);
        double deepest = 0, farthest = 0;
        long passed = 0;
        const auto all = solver.gaussians();
        const auto clay = solver.particles();
        for (std::size_t i = 0; i < all.size(); ++i) {
            const Vec3<double> x = all[i].x;
            deepest =
                std::fmax(deepest, -deepest_contact(solver.colliders(), solver.acting(), x).phi);
            farthest = std::fmax(farthest, length(x - clay[i].x) / dx);
            const bool in_the_way = std::fabs(s.gaussians[i].x.z - 0.5) < 0.5 * radius;
            const double tool = 0.5 + apart(f + 1);
            passed += in_the_way && x.x > tool && clay[i].x.x < tool;
        }
        EXPECT_LT(deepest, 1e-9) << "m, frame " << f;
        EXPECT_LT(farthest, 0.2) << "cells, frame " << f;
        EXPECT_EQ(passed, 0) << "frame " << f;
    }
}

}  // namespace
}  // namespace knead
