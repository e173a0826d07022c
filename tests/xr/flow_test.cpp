// The strict side of the replay runtime: what may be called when, and what is played.
#include "tests/openxr_replay/flow.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/hands/gesture.h"
#include "tests/openxr_replay/clock.h"
#include "tests/openxr_replay/script.h"

namespace knead::replay {
namespace {

using xr::XrState;
using Tellings = std::deque<XrState>;

TEST(ReplaySession, tells_its_states_in_the_order_of_the_specification)
{
    SessionFlow flow;
    EXPECT_EQ(flow.news, (Tellings{XrState::idle, XrState::ready}));
    flow.news.clear();
    EXPECT_EQ(flow.end(), "XR_ERROR_SESSION_NOT_RUNNING");
    EXPECT_EQ(flow.begin(), "");
    EXPECT_EQ(flow.begin(), "XR_ERROR_SESSION_RUNNING");
    EXPECT_EQ(flow.end(), "XR_ERROR_SESSION_NOT_STOPPING");
    EXPECT_FALSE(flow.visible());
    flow.frame_ended(), flow.frame_ended();
    EXPECT_EQ(flow.news, (Tellings{XrState::synchronized, XrState::visible, XrState::focused}));
    flow.news.clear();
    EXPECT_EQ(flow.request_exit(), "");
    EXPECT_EQ(flow.news, (Tellings{XrState::visible, XrState::synchronized, XrState::stopping}));
    flow.news.clear();
    EXPECT_EQ(flow.end(), "");
    EXPECT_EQ(flow.news, (Tellings{XrState::idle, XrState::exiting}));
    EXPECT_EQ(flow.begin(), "XR_ERROR_SESSION_NOT_READY");
}

TEST(ReplaySession, left_before_its_first_frame_skips_no_state_and_comes_back_to_none)
{
    SessionFlow flow;
    flow.begin();
    flow.news.clear();
    EXPECT_EQ(flow.request_exit(), "");
    EXPECT_EQ(flow.news, (Tellings{XrState::synchronized, XrState::stopping}));
    flow.news.clear();
    flow.frame_ended();
    EXPECT_TRUE(flow.news.empty()) << "a frame does not make it visible again";
    EXPECT_EQ(flow.end(), "");
}

TEST(ReplaySession, taken_off_may_begin_again_after_so_many_empty_polls)
{
    SessionFlow flow;
    flow.begin(), flow.frame_ended();
    flow.take_off(3);
    EXPECT_EQ(flow.end(), "");
    flow.news.clear();
    flow.polled_empty(), flow.polled_empty();
    EXPECT_TRUE(flow.news.empty());
    flow.polled_empty();
    EXPECT_EQ(flow.news, Tellings{XrState::ready});
    EXPECT_EQ(flow.begin(), "");
}

TEST(ReplayFrames, are_waited_for_begun_and_ended_in_this_order)
{
    FrameOrder order;
    bool discarded = false;
    EXPECT_EQ(order.may_end(), "XR_ERROR_CALL_ORDER_INVALID");
    EXPECT_EQ(order.end(), "XR_ERROR_CALL_ORDER_INVALID");
    EXPECT_EQ(order.begin(discarded), "XR_ERROR_CALL_ORDER_INVALID");
    EXPECT_TRUE(order.may_wait());
    order.wait();
    EXPECT_FALSE(order.may_wait()) << "a second wait blocks until the frame is begun";
    EXPECT_EQ(order.begin(discarded), "");
    EXPECT_FALSE(discarded);
    EXPECT_EQ(order.end(), "");
    EXPECT_EQ(order.end(), "XR_ERROR_CALL_ORDER_INVALID");
    order.wait();
    order.begin(discarded);
    order.wait();
    EXPECT_EQ(order.begin(discarded), "");
    EXPECT_TRUE(discarded) << "the one before was never ended";
}

TEST(ReplayImages, are_acquired_waited_for_and_released_in_turn)
{
    ImageOrder order(2);
    int index = -1;
    EXPECT_EQ(order.wait(), "XR_ERROR_CALL_ORDER_INVALID");
    EXPECT_EQ(order.release(), "XR_ERROR_CALL_ORDER_INVALID");
    EXPECT_EQ(order.acquire(index), "");
    EXPECT_EQ(index, 0);
    EXPECT_TRUE(order.held());
    EXPECT_EQ(order.release(), "XR_ERROR_CALL_ORDER_INVALID") << "not waited for";
    EXPECT_EQ(order.acquire(index), "");
    EXPECT_EQ(index, 1);
    EXPECT_EQ(order.acquire(index), "XR_ERROR_CALL_ORDER_INVALID") << "all are held";
    EXPECT_EQ(order.wait(), "");
    EXPECT_EQ(order.wait(), "XR_ERROR_CALL_ORDER_INVALID") << "one at a time";
    EXPECT_FALSE(order.ever_released());
    EXPECT_EQ(order.release(), "");
    EXPECT_EQ(order.last_released(), 0);
    EXPECT_EQ(order.acquire(index), "");
    EXPECT_EQ(index, 0);
}

TEST(ReplayPaths, are_told_from_what_is_none)
{
    for (const char* good : {"/user/hand/left", "/a", "/input/select_1/value-2.x"})
        EXPECT_TRUE(is_path(good)) << good;
    EXPECT_TRUE(is_path("/" + std::string(254, 'a')));
    EXPECT_FALSE(is_path("/" + std::string(255, 'a'))) << "longer than XR_MAX_PATH_LENGTH";
    for (const char* bad : {"", "/", "user", "/User", "/a//b", "/a/", "/a/..", "/a b"})
        EXPECT_FALSE(is_path(bad)) << bad;
    EXPECT_TRUE(is_name("clay"));
    EXPECT_FALSE(is_name("Clay"));
    EXPECT_FALSE(is_name(""));
}

TEST(ReplayClock, has_even_frames_to_the_nanosecond_and_changes_its_rate_without_a_leap)
{
    FrameClock clock(90, 1000);
    EXPECT_EQ(clock.next(0), 1000);
    for (std::int64_t k = 1; k < 1000; ++k)
        EXPECT_EQ(clock.next(0), 1000 + std::llround(double(k) * 1e9 / 90));
    const std::int64_t last = clock.time(999);
    clock.change(72);
    EXPECT_NEAR(double(clock.next(0) - last), 1e9 / 72, 2);
    EXPECT_EQ(clock.period(), 13888889);
}

TEST(ReplayClock, in_real_time_leaves_out_what_can_no_longer_be_seen)
{
    FrameClock clock(100, 0);
    clock.next(1);
    const std::int64_t seen = clock.next(55'000'000);
    EXPECT_GE(seen, 55'000'000 - clock.lead());
    EXPECT_EQ(seen % 10'000'000, 0);
}

TEST(ReplayScript, plays_the_recording_and_spoils_it_where_a_fault_says_so)
{
    Script script;
    script.head.push_back({});
    script.hands = generate("squeeze");
    const double time = script.at_frame(50);
    const HandAnswer sound = hand_at(script, right, time);
    ASSERT_TRUE(sound.active);
    EXPECT_TRUE(sound.hand.valid[wrist]);
    EXPECT_GT(sound.hand.radius[wrist], 2 * sound.hand.radius[index_tip]);

    script.faults.push_back({FaultKind::lose_hand, 50, 2, right, 0});
    EXPECT_FALSE(hand_at(script, right, time).active);
    EXPECT_TRUE(hand_at(script, left, time).active);
    EXPECT_TRUE(hand_at(script, right, script.at_frame(52)).active);

    script.faults = {{FaultKind::invalid_fingers, 50, 1, {}, 0}};
    EXPECT_TRUE(hand_at(script, right, time).hand.valid[wrist]);
    EXPECT_FALSE(hand_at(script, right, time).hand.valid[index_tip]);
    script.faults = {{FaultKind::invalid_joints, 50, 1, {}, 0}};
    EXPECT_TRUE(hand_at(script, right, time).active);
    EXPECT_FALSE(hand_at(script, right, time).hand.valid[wrist]);
    script.faults = {{FaultKind::constant_radii, 50, 1, {}, 0}};
    EXPECT_FLOAT_EQ(hand_at(script, right, time).hand.radius[wrist], 0.01f);
    script.faults = {{FaultKind::leap, 50, 1, {}, 0}};
    EXPECT_NEAR(hand_at(script, right, time).hand.joints[wrist].p.y,
                sound.hand.joints[wrist].p.y + 0.3f, 1e-6f);
    EXPECT_FALSE(hand_at(script, right, script.hands->frames.back().time + 1).active);
}

TEST(ReplayScript, has_its_eyes_apart_across_the_gaze)
{
    Script script;
    script.eyes_apart = 0.06;
    const double quarter = std::sqrt(0.5);
    script.head.push_back({0, {{quarter, 0, quarter, 0}, {0, 1, 0}}});  // looks along -x
    const Vec3<double> apart = eye_at(script, 0, 1).p - eye_at(script, 0, 0).p;
    EXPECT_NEAR(apart.z, -0.06, 1e-12);
    EXPECT_NEAR(apart.x, 0, 1e-12);
}

}  // namespace
}  // namespace knead::replay
