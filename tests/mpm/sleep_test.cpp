// Clay that need not move: what sleeps, what wakes, and what neither may change.
#include "cuda/mpm/sleep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/solver/audit.h"
#include "host/solver/editable_simulator.h"
#include "host/solver/pieces.h"
#include "tests/mpm/resting.h"
#include "tests/sanitized.h"

namespace knead {
namespace {

using namespace resting;
using resting::Given;  // not that of scenes

class Rests : public Resting {};
INSTANTIATE_TEST_SUITE_P(Solver, Rests, testing::ValuesIn(backends),
                         [](const auto& at) { return std::string(at.param.name); });

TEST_P(Rests, ClayOnTheFloorFallsAsleepCostsNothingAndStaysAsItIs)
{
    Given s = scene({24, 16, 24}, 1e5);
    s.gravity = {0, -9.81, 0};
    add(s, {7, 3, 7}, {17, 8, 17});
    const auto solver = make(s);
    FrameStats stats = solver->advance(nowhere, frame);
    EXPECT_EQ(stats[Count::moved], long(s.particles.size()) * stats.substeps);
    int frames = 1;
    while (stats[Count::moved] > 0 && ++frames < 90) stats = solver->advance(nowhere, frame);
    EXPECT_LT(frames, 90) << "still awake after a second";
    const Particles asleep = solver->particles();
    const Audit before = audit(asleep, s.materials, dx);
    EXPECT_EQ(before.kinetic, 0);
    for (const auto& p : asleep) ASSERT_EQ(p.sides, 0u) << "who is still is nobody else's concern";
    EXPECT_NEAR(before.volume, audit(s.particles, s.materials, dx).volume, 1e-3 * before.volume);
    for (int f = 0; f < 100; ++f) {
        stats = solver->advance(nowhere, frame);
        ASSERT_EQ(stats[Count::moved], 0);
        ASSERT_EQ(stats[Count::woken], 0);
    }
    const Particles after = solver->particles();
    for (std::size_t i = 0; i < after.size(); ++i) ASSERT_TRUE(same(after[i], asleep[i])) << i;
}

// A bar of 32 cells floats at rest; a cube flies into its end, 12 cells away. What the bar's sleep
// may cost is stated by what it is compared with: the same without. A wave crosses all of the bar
// in a frame.
TEST_P(Rests, ABlowWakesABarAndTravelsThroughItAsIfItHadNotSlept)
{
    Given s = scene({64, 16, 16});
    add(s, {24, 5, 5}, {56, 10, 10});
    const std::size_t bar = s.particles.size();
    const double long_frame = 1.0 / 30;
    s.rest.frames = 3;
    add(s, {8, 5, 5}, {12, 10, 10}, {2, 0, 0});
    const auto slept = make(s), other = awake_throughout(s);
    const auto far_end = [&](const Particles& q, auto&& part) {
        double sum = 0;
        int count = 0;
        for (std::size_t i = 0; i < bar; ++i)
            if (s.particles[i].x.x > 55 * dx) sum += part(q[i]), ++count;
        return sum / count;
    };
    const auto place = [](const Particle<double>& p) { return p.x.x; };
    const auto speed = [](const Particle<double>& p) { return p.v.x; };
    long woken = 0, min_moved = 1L << 60;
    double late = -1, dt = 0;
    for (int f = 0; f < 14; ++f) {
        const FrameStats stats = slept->advance(nowhere, long_frame);
        dt = other->advance(nowhere, long_frame).dt_max;
        woken += stats[Count::woken],
            min_moved = std::min(min_moved, stats[Count::moved] / stats.substeps);
        const Particles a = slept->particles(), b = other->particles();
        if (late < 0 && far_end(b, speed) > 0.1)
            late = (far_end(b, place) - far_end(a, place)) / far_end(b, speed);
        for (const auto& p : a) ASSERT_TRUE(std::isfinite(p.x.x + p.v.x + p.e.xx));
    }
    EXPECT_LT(min_moved, long(s.particles.size() - bar / 2)) << "the bar did not sleep";
    EXPECT_GT(woken, 7);
    EXPECT_GE(late, -dt);
    EXPECT_LT(late, 4 * dt) << "s, over eight blocks";
    const Particles a = slept->particles(), b = other->particles();
    const Audit first = audit(s.particles, s.materials, dx), with = audit(a, s.materials, dx),
                without = audit(b, s.materials, dx);
    EXPECT_EQ(with.mass, first.mass);
    EXPECT_NEAR(without.momentum.x, first.momentum.x, 1e-4 * first.momentum.x);
    EXPECT_NEAR(with.momentum.x, first.momentum.x, 0.005 * first.momentum.x);
    EXPECT_NEAR(with.kinetic + with.elastic, without.kinetic + without.elastic,
                0.005 * (without.kinetic + without.elastic));
    EXPECT_NEAR(with.volume, without.volume, 1e-3 * without.volume);
    EXPECT_LT(apart(a, b).mean, 0.03);
    EXPECT_LT(apart(a, b).max, 0.15);
}

// In a fifteenth of a second the cube flies from where it and its neighbours were found awake,
// across blocks without clay, into clay that was asleep when the frame began.
// What wakes late has taken momentum meanwhile, the more the longer the substep.
TEST_P(Rests, ClayThatFliesIntoSleepingClayWakesItWithinTheFrame)
{
    for (const auto& [courant, lost] : {std::pair{0.55, 1e-3}, {0.8, 3e-3}}) {
        Given s = scene({64, 16, 16});
        add(s, {24, 5, 5}, {31, 10, 10});
        add(s, {5, 6, 6}, {8, 9, 9}, {12, 0, 0});
        s.rest.frames = 1;
        s.step.courant = courant;
        const auto slept = make(s), other = awake_throughout(s);
        const FrameStats stats = slept->advance(nowhere, 1.0 / 15);
        other->advance(nowhere, 1.0 / 15);
        EXPECT_GT(stats[Count::woken], 0);
        EXPECT_LT(stats[Count::moved], long(s.particles.size()) * stats.substeps * 3 / 4);
        const Particles a = slept->particles(), b = other->particles();
        const double first = audit(s.particles, s.materials, dx).momentum.x;
        EXPECT_NEAR(audit(a, s.materials, dx).momentum.x, first, lost * first);
        EXPECT_LT(apart(a, b).mean, lost);
        EXPECT_LT(apart(a, b).max, 0.01);
    }
}

TEST_P(Rests, ClayThatDriftsAgainstSleepingClayPushesItAlong)
{
    Given s = scene({52, 16, 16});
    add(s, {28, 5, 5}, {34, 10, 10});
    const std::size_t first = s.particles.size();
    add(s, {9, 5, 5}, {14, 10, 10}, {0.5, 0, 0});
    const auto solver = make(s);
    long slept = 0;
    for (int f = 0; f < 110; ++f) {
        const FrameStats stats = solver->advance(nowhere, frame);
        slept += stats[Count::moved] == long(s.particles.size() - first) * stats.substeps;
    }
    EXPECT_GT(slept, 20) << "frames";
    const Particles q = solver->particles();
    double hit = 0, all = 0, given = 0;
    for (std::size_t i = 0; i < q.size(); ++i) {
        if (i < first) hit += q[i].v.x;
        all += q[i].v.x, given += s.particles[i].v.x;
    }
    EXPECT_NEAR(all, given, 0.02 * given);
    EXPECT_GT(hit, 0.3 * given);
}

TEST_P(Rests, AHandThatPressesOneEndOfASlabLeavesTheOtherAsleep)
{
    std::vector<double> mean, most;
    for (const double courant : {0.6, 0.7, 0.8}) {
        if (sanitized && courant != 0.7) continue;  // no middle of three then
        Pressed slab;
        slab.s.step.courant = courant;
        const Given& s = slab.s;
        const auto slept = make(s), other = awake_throughout(s);
        const Vec3<double> above{10 * dx, 14 * dx, 9 * dx};
        for (int f = 0; f < 12; ++f)
            for (EditableSimulator* one : {slept.get(), other.get()})
                one->advance(at(above, above), frame);
        const long moved = slab.press(*slept, 1.5 * dx, 20)[Count::moved];
        EXPECT_LT(moved, slab.press(*other, 1.5 * dx, 20)[Count::moved] / 2);
        const Particles a = slept->particles(), b = other->particles();
        double pressed = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const Vec3<double> x = s.particles[i].x;
            pressed = std::fmax(pressed, x.y - a[i].x.y);
            ASSERT_TRUE(x.x <= 48 * dx || length(a[i].x - x) == 0) << i;
        }
        EXPECT_GT(pressed, dx);
        EXPECT_NEAR(audit(a, s.materials, dx).volume, audit(b, s.materials, dx).volume,
                    1e-3 * audit(b, s.materials, dx).volume);
        mean.push_back(apart(a, b).mean), most.push_back(apart(a, b).max);
    }
    if (sanitized) return;
    // Contact multiplies what a GPU rounds, and with some lengths of substeps what a CPU does: the
    // farthest of all particles scatters from 0.002 to 0.023, their mean up to 0.0021.
    for (std::vector<double>* all : {&mean, &most}) std::sort(all->begin(), all->end());
    EXPECT_TRUE(mean[1] < 2e-3 && most[1] < 0.02) << mean[1] << ", " << most[1];
}

TEST_P(Rests, AKnifePartsSleepingClayAndBothPiecesFallAsleep)
{
    Given s = scene({32, 16, 24}, 8e3);
    s.walls.mode = ContactMode::separate, s.gravity = {0, -9.81, 0};
    add(s, {11, 3, 9}, {21, 7, 15});
    for (const Vec3<float>& corner : {Vec3<float>{0, 0, -0.6f}, {0, 0, 0.6f}, {0, 0.9f, 0}}) {
        Binding<float> b{};
        b.weight[0] = 1, b.offset[0] = corner, b.radius = 1e-3f;
        s.rig.spheres.push_back(b);
    }
    s.rig.primitives = {{3, {0, 1, 2}, 0}};
    s.tools = {{ContactMode::separate, 0.1, true, true}};
    const auto solver = make(s);
    const auto falls_asleep = [&] {
        const Motion above = at({0.5, 0.65, 0.375}, {0.5, 0.65, 0.375});
        for (int f = 0; f < 90; ++f)
            if (solver->advance(above, frame)[Count::moved] == 0) return true;
        return false;
    };
    EXPECT_TRUE(falls_asleep());
    const auto height = [](int f) { return f < 20 ? 0.65 - 0.03 * f : 0.05 + 0.06 * (f - 20); };
    for (int f = 0; f < 30; ++f)
        solver->advance(at({0.5, height(f), 0.375}, {0.5, height(f + 1), 0.375}), frame);
    EXPECT_TRUE(falls_asleep());
    std::vector<int> piece;
    EXPECT_EQ(pieces(solver->particles(), s.lattice, piece), 2);
}

TEST_P(Rests, WhereNothingMaySleepAllIsAsWithoutTheRule)
{
    Pressed slab;
    Given& s = slab.s;
    s.gravity = {0, -9.81, 0}, s.rest.frames = 1000, s.deterministic = true;
    const auto solver = make(s), plain = awake_throughout(s);
    for (int f = 0; f < 3; ++f) {  // each multiplies by ten or more what kernels round otherwise
        const Motion motion = at({0.3, 0.33 - 0.01 * f, 0.3}, {0.3, 0.32 - 0.01 * f, 0.3});
        const FrameStats a = solver->advance(motion, frame), b = plain->advance(motion, frame);
        EXPECT_EQ(a.substeps, b.substeps);
        EXPECT_EQ(a[Count::moved], long(s.particles.size()) * a.substeps);
        EXPECT_EQ(b[Count::moved], a[Count::moved]);
        EXPECT_EQ(a[Count::woken] + b[Count::woken], 0);
    }
    const Particles a = solver->particles(), b = plain->particles();
    EXPECT_LT(apart(a, b).max, 1e-3);
    if (GetParam().make == on_device) return;  // other kernels may round otherwise
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_TRUE(same(a[i], b[i])) << i;
}

TEST(Rest, TheBitsAreTheSameForAnyNumberOfThreads)
{
    for (const RestMode mode : {RestMode::sleep, RestMode::localized}) {
        Pressed slab;
        Given& s = slab.s;
        add(s, {50, 9, 6}, {54, 12, 10}, {0, -1, 0});
        s.rest.mode = mode, s.rest.frames = 2;
        Particles first;
        long woken = 0, moved = 0;
        for (const int threads : {1, 3}) {
            s.threads = threads;
            const auto solver = cpu_solver(s);
            const long before = moved;
            for (int f = 0; f < 3; ++f) woken += solver->advance(nowhere, frame)[Count::woken];
            moved = slab.press(*solver, 1.5 * dx, 8)[Count::moved];
            if (threads > 1) {
                EXPECT_EQ(moved, before);
            }
            const Particles q = solver->particles();
            if (first.empty()) first = q;
            for (std::size_t i = 0; i < q.size(); ++i) ASSERT_TRUE(same(q[i], first[i])) << i;
        }
        if (mode == RestMode::sleep) {
            EXPECT_GT(woken, 0);
        }
    }
}

}  // namespace
}  // namespace knead
