// When frames of a live session are due, what is left out of them, and what is made up for.
#include "tests/live/live_slow.h"

namespace knead {
namespace {

TEST_F(Live, FramesAreDueOnTheClock)
{
    prepare = [](Slow& s) { s.substep = 0; };
    LiveSession session(scene, options);
    session.wait_for_commands();
    once(session, [](const LiveState& s) { return s.frame.number == 1; });
    clock = 0.01;
    once(session, [](const LiveState& s) { return s.frame.number == 2; });
    clock = 0.0199;
    session.wait_for_commands();
    session.inspect_solver([&](const Simulator&) { EXPECT_EQ(slow->frames, 2); });
    clock = 0.02;
    const auto state = once(session, [](const LiveState& s) { return s.frame.number == 3; });
    EXPECT_EQ(state->backlog.frames, 0);
    EXPECT_EQ(state->backlog.missing_time, 0);
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
    EXPECT_GE(state->backlog.missing_time, state->frame.number * 0.01 * 8 / 20);
    EXPECT_NEAR(simulated + state->backlog.missing_time, clock, 0.05);
    EXPECT_EQ(state->failure, "");
}

TEST_F(Live, ALongPauseOfTheMachineIsNotMadeUpFor)
{
    prepare = [](Slow& s) { s.substep = 0; };
    LiveSession session(scene, options);
    session.wait_for_commands();
    once(session, [](const LiveState& s) { return s.frame.number == 1; });
    clock = 10;
    const auto state = once(session, [](const LiveState& s) { return s.backlog.missing_time > 9; });
    session.wait_for_commands();
    session.inspect_solver([&](const Simulator&) { EXPECT_LE(slow->frames, 4); });
    EXPECT_NEAR(state->backlog.missing_time, 9.98, 0.02);
}

// Two frames are left out; eight that are due a fifth of a frame earlier, and two at once, make up
// for them.
TEST_F(Live, AShortDelayIsMadeUpForWhereFramesLeaveTime)
{
    prepare = [](Slow& s) { s.substep = 0; };
    LiveSession session(scene, options);
    session.wait_for_commands();
    once(session, [](const LiveState& s) { return s.frame.number == 1; });
    clock = 0.05;  // five more are due
    const auto late = once(session, [](const LiveState& s) { return s.frame.number == 4; });
    EXPECT_NEAR(late->backlog.missing_time, 0.016, 1e-9);
    for (int i = 0; i < 8; ++i) {
        clock = 0.056 + 0.008 * i + 1e-6;
        once(session, [&](const LiveState& s) { return s.frame.number == 5 + i; });
    }
    EXPECT_NEAR(session.state()->backlog.missing_time, 0, 1e-9);
    EXPECT_NEAR(session.state()->frame.number * 0.01, clock, 0.01) << "as if nothing had been";
    for (const double time : {0.1199, 0.1299}) {  // due at whole frames again
        clock = time;
        session.wait_for_commands();
        std::this_thread::sleep_for(std::chrono::milliseconds(30));
        EXPECT_EQ(session.state()->frame.number, int(100 * time) + 1);
    }
}

TEST_F(Live, WhatTakesHalfOfItsTimeOrMoreMakesUpForNothing)
{
    prepare = [](Slow& s) { s.substep = 0.3e-3; };  // 6 of 10 ms
    LiveSession session(scene, options);
    session.wait_for_commands();
    once(session, [](const LiveState& s) { return s.frame.number == 1; });
    clock = clock + 0.1;
    const auto late =
        once(session, [](const LiveState& s) { return s.backlog.missing_time > 0.05; });
    const double behind = late->backlog.missing_time;
    for (int i = 0; i < 50; ++i) {
        const int number = session.state()->frame.number;
        clock = clock + 0.01;
        once(session, [&](const LiveState& s) { return s.frame.number > number; });
    }
    EXPECT_GE(session.state()->backlog.missing_time, behind - 0.011);
}

TEST_F(Live, TimeBeginsWhenItIsStartedNotWhenTheSolverIs)
{
    prepare = [](Slow& s) { s.substep = 0; };
    options.manual_start = true;
    options.make_solver = [make = options.make_solver, this](const auto& setup) {
        clock = clock + 0.4;  // that it takes
        return make(setup);
    };
    LiveSession session(scene, options);
    session.wait_for_commands();
    clock = clock + 1;
    session.wait_for_commands();
    EXPECT_EQ(session.state()->frame.number, 0);
    session.start();
    session.wait_for_commands();
    const auto first = once(session, [](const LiveState& s) { return s.frame.number == 1; });
    EXPECT_EQ(first->backlog.missing_time, 0);
    clock = clock + 0.01;
    const auto second = once(session, [](const LiveState& s) { return s.frame.number == 2; });
    EXPECT_EQ(second->backlog.missing_time, 0);
    session.send(Reset{});
    session.wait_for_commands();
    const auto again = once(session, [](const LiveState& s) { return s.history == 2; });
    EXPECT_EQ(again->backlog.missing_time, 0) << "another solver, as slowly made";
}

}  // namespace
}  // namespace knead
