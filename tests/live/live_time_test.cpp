// When frames of a live session are due, what is left out of them, and what is made up for.
#include "tests/live/live_slow.h"

namespace knead {
namespace {

TEST_F(Live, FramesAreDueOnTheClock)
{
    prepare = [](Slow& s) { s.substep = 0; };
    LiveSession session(scene, options);
    session.settle();
    once(session, [](const LiveState& s) { return s.frame.number == 1; });
    clock = 0.01;
    once(session, [](const LiveState& s) { return s.frame.number == 2; });
    clock = 0.0199;
    session.settle();
    session.inspect_solver([&](const Simulator&) { EXPECT_EQ(slow->frames, 2); });
    clock = 0.02;
    const auto state = once(session, [](const LiveState& s) { return s.frame.number == 3; });
    EXPECT_EQ(state->backlog.frames, 0);
    EXPECT_EQ(state->backlog.behind, 0);
}

// 20 substeps of 1 ms, and 10 ms for a frame: half of every frame is shed, and no more.
TEST_F(Live, WhatDoesNotFitIntoTheBudgetIsShedAndCounted)
{
    LiveSession session(scene, options);
    const auto state = once(session, [](const LiveState& s) { return s.frame.number >= 50; });
    EXPECT_EQ(state->backlog.frames, state->frame.number);
    EXPECT_NEAR(state->frame.stats.substeps, 11, 1);
    const double simulated = state->frame.simulated;
    EXPECT_NEAR(simulated, state->frame.number * 0.01 * 11 / 20, 0.1 * simulated);
    EXPECT_GE(state->backlog.behind, state->frame.number * 0.01 * 8 / 20);
    EXPECT_NEAR(simulated + state->backlog.behind, clock, 0.05);
    EXPECT_EQ(state->trouble, "");
}

TEST_F(Live, ALongPauseOfTheMachineIsNotMadeUpFor)
{
    prepare = [](Slow& s) { s.substep = 0; };
    LiveSession session(scene, options);
    session.settle();
    once(session, [](const LiveState& s) { return s.frame.number == 1; });
    clock = 10;
    const auto state = once(session, [](const LiveState& s) { return s.backlog.behind > 9; });
    session.settle();
    session.inspect_solver([&](const Simulator&) { EXPECT_LE(slow->frames, 4); });
    EXPECT_NEAR(state->backlog.behind, 9.98, 0.02);
}

// Two frames are left out; eight that are due a fifth of a frame earlier, and two at once, make up
// for them.
TEST_F(Live, AShortDelayIsMadeUpForWhereFramesLeaveTime)
{
    prepare = [](Slow& s) { s.substep = 0; };
    LiveSession session(scene, options);
    session.settle();
    once(session, [](const LiveState& s) { return s.frame.number == 1; });
    clock = 0.05;  // five more are due
    const auto late = once(session, [](const LiveState& s) { return s.frame.number == 4; });
    EXPECT_NEAR(late->backlog.behind, 0.016, 1e-9);
    for (int i = 0; i < 8; ++i) {
        clock = 0.056 + 0.008 * i + 1e-6;
        once(session, [&](const LiveState& s) { return s.frame.number == 5 + i; });
    }
    EXPECT_NEAR(session.state()->backlog.behind, 0, 1e-9);
    EXPECT_NEAR(session.state()->frame.number * 0.01, clock, 0.01) << "as if nothing had been";
    for (const double time : {0.1199, 0.1299}) {  // due at whole frames again
        clock = time;
        session.settle();
        std::this_thread::sleep_for(std::chrono::milliseconds(30));
        EXPECT_EQ(session.state()->frame.number, int(100 * time) + 1);
    }
}

TEST_F(Live, WhatTakesHalfOfItsTimeOrMoreMakesUpForNothing)
{
    prepare = [](Slow& s) { s.substep = 0.3e-3; };  // 6 of 10 ms
    LiveSession session(scene, options);
    session.settle();
    once(session, [](const LiveState& s) { return s.frame.number == 1; });
    clock = clock + 0.1;
    const auto late = once(session, [](const LiveState& s) { return s.backlog.behind > 0.05; });
    const double behind = late->backlog.behind;
    for (int i = 0; i < 50; ++i) {
        const int number = session.state()->frame.number;
        clock = clock + 0.01;
        once(session, [&](const LiveState& s) { return s.frame.number > number; });
    }
    EXPECT_GE(session.state()->backlog.behind, behind - 0.011);
}

TEST_F(Live, TimeBeginsWhenItIsStartedNotWhenTheSolverIs)
{
    prepare = [](Slow& s) { s.substep = 0; };
    options.waits = true;
    options.make = [make = options.make, this](const auto& setup) {
        clock = clock + 0.4;  // that it takes
        return make(setup);
    };
    LiveSession session(scene, options);
    session.settle();
    clock = clock + 1;
    session.settle();
    EXPECT_EQ(session.state()->frame.number, 0);
    session.start();
    session.settle();
    const auto first = once(session, [](const LiveState& s) { return s.frame.number == 1; });
    EXPECT_EQ(first->backlog.behind, 0);
    clock = clock + 0.01;
    const auto second = once(session, [](const LiveState& s) { return s.frame.number == 2; });
    EXPECT_EQ(second->backlog.behind, 0);
    session.reset();
    session.settle();
    const auto again = once(session, [](const LiveState& s) { return s.history == 2; });
    EXPECT_EQ(again->backlog.behind, 0) << "another solver, as slowly made";
}

}  // namespace
}  // namespace knead
