// What hands have left goes back while frames go on.
#include "tests/session/local_scene.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

class LocalLeaving : public LocalScene {
  protected:
    // Of which two runs have the same bits.
    void begin_anew(bool beside_frames)
    {
        make();
        scene.setup.deterministic = true;
        solver = made();
        beside = beside_frames;
    }
};

TEST_P(LocalLeaving, WhatGoesBackBesideFramesGoesBackAlike)
{
    SplatCloud stands[2];
    for (const bool beside_frames : {false, true}) {
        begin_anew(beside_frames);
        press({0.5, 0.2, 0.5});
        leave();
        EXPECT_EQ(local->leaving(), local->end_leaving(*solver));
        EXPECT_FALSE(local->leaving());
        EXPECT_TRUE(solver->particles().empty());
        EXPECT_EQ(moving->cloud().count(), 0u);
        stands[beside_frames] = local->still();
        EXPECT_GT(dent({0.5, 0.2, 0.5}), 0.015);
    }
    EXPECT_TRUE(same_bits(stands[0].centre, stands[1].centre));
    EXPECT_TRUE(same_bits(stands[0].scale, stands[1].scale));
    EXPECT_TRUE(same_bits(stands[0].rotation, stands[1].rotation));
}

TEST_P(LocalLeaving, AHandThatReturnsFindsClayThere)
{
    begin_anew(true);
    const Place at{0.5, 0.2, 0.5}, near = at + Place{0, 0.03, 0};
    press(at, 0.02);
    for (int f = 0; f < 40 && !local->leaving(); ++f) move(away, away, away, away, 1);
    ASSERT_TRUE(local->leaving());
    EXPECT_FALSE(solver->particles().empty());
    move(near, near, away, away, 1);
    EXPECT_FALSE(local->leaving());
    EXPECT_GT(report.given_back, 0u);
    EXPECT_GT(report.taken, 0u);
    const double first = dent(at, 0.2);
    move(near, at - Place{0, 0.045, 0}, away, away, 15);
    move(at - Place{0, 0.045, 0}, near, away, away, 15);
    leave();
    local->end_leaving(*solver);
    EXPECT_GT(dent(at), first + 0.008);
    EXPECT_EQ(repaired, 0);
}

INSTANTIATE_TEST_SUITE_P(Session, LocalLeaving, ::testing::Bool(),
                         [](const auto& device) { return device.param ? "cuda" : "cpu"; });

}  // namespace
}  // namespace knead
