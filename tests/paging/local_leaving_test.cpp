// What hands have left goes back while frames go on.
#include "tests/paging/local_scene.h"
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
    // Until it begins to go back.
    void begin_to_leave()
    {
        for (int f = 0; f < 40 && !local->freezing(); ++f) move(away, away, away, away, 1);
        ASSERT_TRUE(local->freezing());
    }
};

// Between two frames, or beside them: waited for in the frame in which it begins, or found done
// after so many frames as it takes.
TEST_P(LocalLeaving, WhatGoesBackBesideFramesGoesBackAlike)
{
    enum Way { between, waited_for, found };
    SplatCloud stands[3];
    for (const Way way : {between, waited_for, found}) {
        begin_anew(way != between);
        press({0.5, 0.2, 0.5});
        if (way == between) {
            leave();
        } else {
            ASSERT_NO_FATAL_FAILURE(begin_to_leave());
        }
        for (int f = 0; f < 1000 && way == found && local->freezing(); ++f)
            move(away, away, away, away, 1);
        const bool was_freezing = local->freezing();
        EXPECT_EQ(local->finish_freezing(*solver), was_freezing);
        EXPECT_FALSE(local->freezing());
        EXPECT_TRUE(solver->particles().empty());
        EXPECT_EQ(moving->cloud().count(), 0u);
        stands[way] = local->slots_cloud();
        EXPECT_GT(dent({0.5, 0.2, 0.5}), 0.015);
        EXPECT_TRUE(same_bits(stands[between].centre, stands[way].centre)) << way;
        EXPECT_TRUE(same_bits(stands[between].scale, stands[way].scale)) << way;
        EXPECT_TRUE(same_bits(stands[between].rotation, stands[way].rotation)) << way;
    }
}

// Or what the thread finds would be of the past when it is done.
TEST_P(LocalLeaving, ClayThatHandsHaveLeftIsHeldStill)
{
    begin_anew(true);
    press({0.5, 0.2, 0.5});
    move(away, away, away, away, 1);
    const std::vector<Gaussian<double>> gaussians = solver->gaussians();
    const std::vector<Particle<double>> particles = solver->particles();
    ASSERT_GT(gaussians.size(), 100u);
    move(away, away, away, away, 20);
    EXPECT_TRUE(same_bits(solver->gaussians(), gaussians));
    EXPECT_TRUE(same_bits(solver->particles(), particles));
}

// The thread moves it in memory.
TEST_P(LocalLeaving, NobodySeesWhatStandsStillMeanwhile)
{
    begin_anew(true);
    press({0.5, 0.2, 0.5});
    begin_to_leave();
    SplatCloud all;
    EXPECT_THROW(local->write_all(all), std::logic_error);
    EXPECT_THROW(local->slots_cloud(), std::logic_error);
    EXPECT_THROW(local->state(), std::logic_error);
    local->finish_freezing(*solver);
    EXPECT_NO_THROW(local->write_all(all));
    EXPECT_EQ(all.count(), local->slots_cloud().count());
}

TEST_P(LocalLeaving, AHandThatReturnsFindsClayThere)
{
    begin_anew(true);
    const Place at{0.5, 0.2, 0.5}, near = at + Place{0, 0.03, 0};
    press(at, 0.02);
    ASSERT_NO_FATAL_FAILURE(begin_to_leave());
    EXPECT_FALSE(solver->particles().empty());
    move(near, near, away, away, 1);
    EXPECT_FALSE(local->freezing());
    EXPECT_GT(report.frozen, 0u);
    EXPECT_GT(report.activated, 0u);
    const double first = dent(at, 0.2);
    move(near, at - Place{0, 0.045, 0}, away, away, 15);
    move(at - Place{0, 0.045, 0}, near, away, away, 15);
    leave();
    local->finish_freezing(*solver);
    EXPECT_GT(dent(at), first + 0.008);
    EXPECT_EQ(repaired, 0);
}

INSTANTIATE_TEST_SUITE_P(Session, LocalLeaving, ::testing::Bool(),
                         [](const auto& device) { return device.param ? "cuda" : "cpu"; });

}  // namespace
}  // namespace knead
