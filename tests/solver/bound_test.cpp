// Frames that end after a given number of substeps: what the replay of a frame that was cut needs.
#include <gtest/gtest.h>

#include <cmath>

#include "host/bench/ball.h"
#include "host/hands/motion.h"
#include "host/solver/gpu/region_padding.h"
#include "host/solver/reference.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/same_bits.h"
#include "tests/solver/stepwise.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
// Powers of two: sums of substeps are exact.
constexpr double step = 0x1p-13, frame = 16 * step;

// A ball with Gaussians between two cones.
Given pressed()
{
    Given s = ball(16);
    add_tools(s), add_gaussians(s, 50);
    s.deterministic = true, s.threads = 2;
    return s;
}
Given falling()
{
    Given s = ball(16);
    add_gaussians(s, 50);
    s.step.fixed = step, s.deterministic = true, s.threads = 2;
    return s;
}

void expect_same_state(const Simulator& a, const Simulator& b)
{
    EXPECT_TRUE(same_bits(a.particles(), b.particles()));
    EXPECT_TRUE(same_bits(a.gaussians(), b.gaussians()));
}

// A frame that was cut after so many substeps, and two that follow it.
void expect_same_frames(Simulator& checked, Simulator& bounded, int most)
{
    const Motion first = closing(0, 1.0 / 90);
    checked.set_stop_check([=](const FrameProgress& p) { return p.substeps >= most; });
    bounded.set_substep_bound(most);
    const FrameStats a = checked.advance(first, 1.0 / 90), b = bounded.advance(first, 1.0 / 90);
    checked.set_stop_check({});
    EXPECT_EQ(b.cut, a.cut);
    EXPECT_EQ(b.substeps, a.substeps);
    EXPECT_EQ(b.reached, a.reached);
    EXPECT_EQ(b.fastest, a.fastest);
    expect_same_state(checked, bounded);
    for (int f = 1; f < 3; ++f) {
        const Motion next = closing(f / 90.0, 1.0 / 90);
        const FrameStats c = checked.advance(next, 1.0 / 90), d = bounded.advance(next, 1.0 / 90);
        EXPECT_FALSE(d.cut);
        EXPECT_EQ(d.substeps, c.substeps);
        expect_same_state(checked, bounded);
    }
}

TEST(SubstepBound, OnTheCpuIsAStopCheckThatCounts)
{
    for (int most = 1; most <= 7; ++most) {
        const Given s = pressed();
        expect_same_frames(*cpu_solver(s), *cpu_solver(s), most);
        Reference checked(s), bounded(s);
        expect_same_frames(checked, bounded, most);
    }
    const Given s = pressed();
    expect_same_frames(*cpu_solver(s), *cpu_solver(s), 1000000);  // never
}

class Bounded : public OnBothDevices {
  protected:
    // Bounded frames among others are those that are as long from the start.
    void expect_shorter_frames() const
    {
        const auto bounded = make(falling()), shorter = make(falling());
        const Motion still = no_motion();
        for (const int most : {3, 1, 15, 9, 2}) {
            bounded->set_substep_bound(most);
            const FrameStats stats = bounded->advance(still, frame);
            EXPECT_TRUE(stats.cut);
            EXPECT_EQ(stats.substeps, most);
            EXPECT_EQ(stats.reached, most * step);
            EXPECT_EQ(shorter->advance(still, most * step).substeps, most);
            expect_same_state(*bounded, *shorter);
            // The next one is whole.
            const FrameStats next = bounded->advance(still, frame);
            EXPECT_EQ(next.substeps, 16);
            EXPECT_FALSE(next.cut);
            shorter->advance(still, frame);
            expect_same_state(*bounded, *shorter);
        }
    }
};
INSTANTIATE_TEST_SUITE_P(Solver, Bounded, testing::Values(false, true), device_of);

TEST_P(Bounded, IsTheShorterFrame) { expect_shorter_frames(); }

TEST_P(Bounded, IsTheShorterFrameSubstepBySubstep)
{
    const Stepwise without_graphs;
    expect_shorter_frames();
}

TEST_P(Bounded, AFrameThatIsCompleteByThenIsWhole)
{
    const auto bounded = make(falling()), whole = make(falling());
    for (const int most : {16, 17, 0x7fffffff, 0}) {
        bounded->set_substep_bound(most);
        const FrameStats stats = bounded->advance(no_motion(), frame);
        EXPECT_FALSE(stats.cut) << most;
        EXPECT_EQ(stats.substeps, 16);
        EXPECT_EQ(stats.reached, 0);
        whole->advance(no_motion(), frame);
        expect_same_state(*bounded, *whole);
    }
    // A bound that is taken back, and one of a frame of no length.
    bounded->set_substep_bound(3), bounded->set_substep_bound(0);
    EXPECT_EQ(bounded->advance(no_motion(), frame).substeps, 16);
    bounded->set_substep_bound(3);
    EXPECT_EQ(bounded->advance(no_motion(), 0).substeps, 0);
    EXPECT_EQ(bounded->advance(no_motion(), frame).substeps, 16);
}

// Unlike behind one that a StopCheck has ended, where it does nothing.
TEST_P(Bounded, OneThatIsSubmittedBehindItIsWhole)
{
    const auto ahead = make(pressed()), one_by_one = make(pressed());
    for (int f = 0; f < 4; ++f) {
        const double from = 2 * f / 90.0, middle = from + 1 / 90.0;
        for (EditableSimulator* each : {ahead.get(), one_by_one.get()}) {
            each->set_substep_bound(2 + f);
            each->submit(closing(from, 1.0 / 90), 1.0 / 90);
            if (each == one_by_one.get()) {
                EXPECT_TRUE(each->collect().cut);
            }
            each->submit(closing(middle, 1.0 / 90), 1.0 / 90);
            if (each == ahead.get()) {
                const FrameStats stats = each->collect();
                EXPECT_TRUE(stats.cut);
                EXPECT_EQ(stats.substeps, 2 + f);
            }
            const FrameStats next = each->collect();
            EXPECT_FALSE(next.cut);
            EXPECT_GT(next.substeps, 2 + f);
        }
        expect_same_state(*ahead, *one_by_one);
    }
}

TEST_P(Bounded, EditsAndSnapshotsFollowIt)
{
    const auto one = make(pressed()), other = make(pressed());
    for (EditableSimulator* each : {one.get(), other.get()}) {
        each->advance(closing(0, 1.0 / 90), 1.0 / 90);
        each->set_substep_bound(4);
        EXPECT_EQ(each->advance(closing(1 / 90.0, 1.0 / 90), 1.0 / 90).substeps, 4);
    }
    const auto then = one->snapshot();
    one->advance(closing(2 / 90.0, 1.0 / 90), 1.0 / 90);
    one->restore(*then);
    for (EditableSimulator* each : {one.get(), other.get()}) {
        EXPECT_FALSE(each->advance(closing(2 / 90.0, 1.0 / 90), 1.0 / 90).cut);
        each->set_gravity({0, 1, 0});
        each->advance(closing(3 / 90.0, 1.0 / 90), 1.0 / 90);
    }
    expect_same_state(*one, *other);
}

// A frame of minutes that is cut wherever it is then, with tools that move, and its replay.
TEST(SubstepBound, OnAGpuRepeatsWhatAStopCheckHasCut)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    Given s = pressed();
    s.gravity = {};
    const auto cut = gpu_solver(s, 0), again = gpu_solver(s, 0);
    const double minutes = 0x1p20 * frame;
    for (int round = 0; round < 3; ++round) {
        const Motion slow = closing(0.01 * round, 0.01);
        int polls = 0;
        cut->set_stop_check([&](const FrameProgress&) { return ++polls == 2; });
        const FrameStats a = cut->advance(slow, minutes);
        cut->set_stop_check({});
        ASSERT_TRUE(a.cut);
        again->set_substep_bound(a.substeps);
        const FrameStats b = again->advance(slow, minutes);
        EXPECT_TRUE(b.cut);
        EXPECT_EQ(b.substeps, a.substeps);
        EXPECT_EQ(b.reached, a.reached);
        expect_same_state(*cut, *again);
        const Motion next = closing(0.01 * (round + 1), 0);
        EXPECT_EQ(cut->advance(next, 1.0 / 90).substeps, again->advance(next, 1.0 / 90).substeps);
        expect_same_state(*cut, *again);
    }
}

// Clay that reaches the end of the stored nodes before, at and after the bound.
TEST(SubstepBound, HoldsWhereTheStoredNodesGrow)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    Given s = ball(64);
    std::erase_if(s.particles, [](const Particle<double>& q) {
        return length(q.x - Vec3<double>{0.5, 0.5, 0.5}) > 0.12;
    });
    Material<double>& m = s.materials[0];
    m.plasticity = Plasticity::fluid, m.bulk = 1e5, m.exponent = 7, m.viscosity = 1;
    for (Particle<double>& q : s.particles) q.v = {120 * (q.x.x - 0.5), 120 * (q.x.y - 0.5), 0.2};
    s.gravity = {}, s.step.fixed = step, s.deterministic = true;
    for (int most = 20; most < 60; most += 3) {
        const auto bounded = gpu_solver(s, 0, RegionPadding{0, 0});
        const auto shorter = gpu_solver(s, 0, RegionPadding{0, 0});
        const std::size_t before = bounded->memory();
        bounded->set_substep_bound(most);
        EXPECT_EQ(bounded->advance(no_motion(), 200 * step).substeps, most);
        EXPECT_EQ(shorter->advance(no_motion(), most * step).substeps, most);
        expect_same_state(*bounded, *shorter);
        bounded->advance(no_motion(), 100 * step), shorter->advance(no_motion(), 100 * step);
        expect_same_state(*bounded, *shorter);
        EXPECT_GT(bounded->memory(), before);
    }
}

}  // namespace
}  // namespace knead
