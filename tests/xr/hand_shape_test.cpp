// Hands around controllers, and radii where a tracker gives none.
#include "xr/hand_shape.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cuda/math/rotation.h"

namespace knead::xr {
namespace {

const Joint<float> upright{{1, 0, 0, 0}, {0.1f, 1.2f, -0.3f}};

TEST(HandAroundGrip, has_its_palm_there_and_the_bones_of_the_default_hand)
{
    for (const Side side : {left, right}) {
        const Hand hand = hand_around(side, upright, 0, 0), open = open_hand(side);
        EXPECT_TRUE(hand.tracked);
        EXPECT_LT(length(hand.joints[palm].p - upright.p), 1e-6f);
        for (int j = 1; j < joint_count; ++j) {
            EXPECT_TRUE(hand.valid[j]);
            EXPECT_NEAR(length(hand.joints[j].p - hand.joints[j - 1].p),
                        length(open.joints[j].p - open.joints[j - 1].p), 1e-5f)
                << joint_names[j];
        }
    }
}

// A grip's -z runs through the fingers towards the thumb; x leaves the right hand by its back.
TEST(HandAroundGrip, lies_as_the_grip_pose_is_defined)
{
    for (const Side side : {left, right}) {
        const Hand hand = hand_around(side, upright, 0, 0);
        const Vec3<float> thumb = hand.joints[thumb_tip].p - hand.joints[little_tip].p;
        EXPECT_LT(thumb.z, -0.02f) << "the thumb is towards -z";
        const Vec3<float> back = rotate(hand.joints[palm].q, Vec3<float>{0, 1, 0});
        EXPECT_NEAR(back.x, side == right ? 1 : -1, 1e-5f);
    }
}

TEST(HandAroundGrip, moves_and_turns_with_the_grip)
{
    const Quat<float> turn = turn_about(Vec3<float>{0, 0.6f, 0.8f}, 1.1f);
    const Joint<float> moved{turn * upright.q, rotate(turn, upright.p)};
    const Hand before = hand_around(right, upright, 0.4f, 0.7f);
    const Hand after = hand_around(right, moved, 0.4f, 0.7f);
    for (int j = 0; j < joint_count; ++j)
        EXPECT_LT(length(after.joints[j].p - rotate(turn, before.joints[j].p)), 1e-5f);
}

TEST(HandAroundGrip, is_closed_by_trigger_and_grasp)
{
    const auto span = [](const Hand& hand, JointName tip) {
        return length(hand.joints[tip].p - hand.joints[wrist].p);
    };
    const Hand open = hand_around(left, upright, 0, 0);
    const Hand pulled = hand_around(left, upright, 1, 0);
    const Hand fist = hand_around(left, upright, 1, 1);
    EXPECT_LT(span(pulled, index_tip), 0.7f * span(open, index_tip));
    EXPECT_FLOAT_EQ(span(pulled, ring_tip), span(open, ring_tip));
    EXPECT_LT(span(fist, ring_tip), 0.7f * span(open, ring_tip));
    const Hand bad = hand_around(left, upright, std::nanf(""), 7);
    EXPECT_TRUE(std::isfinite(span(bad, index_tip)));
    EXPECT_FLOAT_EQ(span(bad, ring_tip), span(fist, ring_tip));
}

TEST(Radii, are_kept_where_they_are_a_hands)
{
    Hand hand = open_hand(right);
    hand.tracked = true, hand.valid.fill(true);
    for (float& r : hand.radius) r *= 1.1f;
    Hand same = hand;
    complete_radii(same, right);
    EXPECT_EQ(same.radius, hand.radius);
}

TEST(Radii, that_are_all_the_same_or_impossible_become_the_default_hands_at_this_size)
{
    const Hand usual = open_hand(right);
    for (const float given : {0.01f, 0.0f, -1.0f, 3.0f, std::numeric_limits<float>::quiet_NaN()}) {
        Hand hand = usual;
        hand.tracked = true, hand.valid.fill(true);
        hand.radius.fill(given);
        for (auto& joint : hand.joints) joint.p = 0.8f * joint.p;
        complete_radii(hand, right);
        for (int j = 0; j < joint_count; ++j)
            EXPECT_NEAR(hand.radius[j], 0.8f * usual.radius[j], 1e-5f) << given;
    }
}

TEST(Radii, of_a_hand_that_is_only_partly_known_are_of_usual_size)
{
    Hand hand = open_hand(left);
    hand.valid.fill(true);
    hand.valid[middle_distal] = false;
    hand.joints[middle_distal].p = {9, 9, 9};
    hand.radius.fill(0.01f);
    complete_radii(hand, left);
    EXPECT_EQ(hand.radius, open_hand(left).radius);
}

}  // namespace
}  // namespace knead::xr
