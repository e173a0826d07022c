// Fists that take clay and let it go.
#include "host/session/fist_gesture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/hands/posture.h"
#include "host/vr/headset_hands.h"

namespace knead {
namespace {

// A hand whose palm is at `place` [m], closed by `share`.
Hand hand_at(Side side, Vec3<double> place, double share, double turn = 0)
{
    const Quat<double> q = turn_about(Vec3<double>{0, 1, 0}, turn);
    const Pose pose = posed(side, {q, {0, 0, 0}}, gripped(share));
    const Vec3<double> shift = place - pose[palm].p;
    Hand hand;
    for (std::size_t j = 0; j < joint_count; ++j)
        hand.joints[j] = {cast<float>(pose[j].q), cast<float>(pose[j].p + shift)};
    hand.tracked = true;
    hand.valid.fill(true);
    return hand;
}

// Clay of category 3 around the simulation's (1, 1, 1).
std::vector<Mesh> clay()
{
    Mesh far, near;
    far.category = 1, far.vertices = {{9, 9, 9}};
    near.category = 3, near.vertices = {{1, 1, 1}, {1.1f, 1, 1}};
    return {far, near};
}

HandsOptions options()
{
    HandsOptions made;
    made.zoom = 2, made.at = {1, 1, 1};
    return made;
}

TEST(Closure, is_none_of_a_flat_hand_and_all_of_a_fist)
{
    for (const Side side : {left, right}) {
        EXPECT_LT(closure(hand_at(side, {0, 0, 0}, 0)), 0.2f);
        EXPECT_GT(closure(hand_at(side, {0, 0, 0}, 1)), 0.9f);
        EXPECT_GT(closure(hand_at(side, {0, 0, 0}, 0.9)), closure(hand_at(side, {0, 0, 0}, 0.5)));
        Hand lost = hand_at(side, {0, 0, 0}, 1);
        lost.tracked = false;
        EXPECT_EQ(closure(lost), 0);
        Hand half = hand_at(side, {0, 0, 0}, 1);
        half.valid[index_distal] = false;
        EXPECT_EQ(closure(half), 0) << "nobody knows";
    }
}

TEST(FistGesture, takes_the_nearest_clay_once_and_holds_it_until_the_fist_opens)
{
    FistGesture hold;
    HandFrame hands;
    hands.hand[right] = hand_at(right, {0.02, 0, 0}, 0);
    EXPECT_FALSE(hold.frame(hands, options(), clay()).took);
    hands.hand[right] = hand_at(right, {0.02, 0, 0}, 1);
    const auto took = hold.frame(hands, options(), clay());
    ASSERT_TRUE(took.took);
    EXPECT_EQ(*took.took, 3);
    EXPECT_EQ(took.by, right);
    EXPECT_TRUE(hold.holds());

    // Far from all clay, and with the other fist at it: what is held stays held.
    hands.hand[right] = hand_at(right, {0.02, 0.5, 0}, 1, 0.5);
    hands.hand[left] = hand_at(left, {0.02, 0, 0}, 1);
    const auto moved = hold.frame(hands, options(), clay());
    EXPECT_FALSE(moved.took || moved.let_go);
    EXPECT_TRUE(hold.holds());

    hands.hand[left].tracked = false;
    hands.hand[right] = hand_at(right, {0.02, 0.1, 0}, 0);
    const auto freed = hold.frame(hands, options(), clay());
    EXPECT_TRUE(freed.let_go);
    EXPECT_EQ(freed.by, right);
    EXPECT_FALSE(hold.holds());
    EXPECT_FALSE(hold.frame(hands, options(), clay()).let_go);
}

TEST(FistGesture, takes_nothing_that_is_out_of_reach_and_lets_go_where_a_hand_is_lost)
{
    FistGesture hold;
    HandFrame hands;
    hands.hand[left] = hand_at(left, {0.3, 0, 0}, 1);
    EXPECT_FALSE(hold.frame(hands, options(), clay()).took);
    EXPECT_FALSE(hold.frame(hands, options(), {}).took) << "no clay at all";
    hands.hand[left] = hand_at(left, {0.02, 0, 0}, 1);
    const auto took = hold.frame(hands, options(), clay());
    EXPECT_TRUE(took.took);
    EXPECT_EQ(took.by, left);
    hands.hand[left].tracked = false;
    EXPECT_TRUE(hold.frame(hands, options(), clay()).let_go);
}

TEST(FistGesture, takes_nothing_with_two_fists_which_move_the_scene)
{
    FistGesture hold;
    HandFrame hands;
    hands.hand[left] = hand_at(left, {-0.02, 0, 0}, 1);
    hands.hand[right] = hand_at(right, {0.02, 0, 0}, 1);
    EXPECT_FALSE(hold.frame(hands, options(), clay()).took);
    hands.hand[left] = hand_at(left, {-0.02, 0, 0}, 0);
    EXPECT_TRUE(hold.frame(hands, options(), clay()).took);
}

TEST(HeadsetHands, keep_their_place_before_the_user_when_the_zoom_changes)
{
    HeadsetHands hands{options()};
    HandFrame frame;
    frame.hand[right] = hand_at(right, {0.1, 0, 0}, 0);
    for (int k = 0; k < 90; ++k) {
        frame.time = k / 90.0;
        hands.push(frame);
        hands.looks();
    }
    hands.set_zoom(1);
    EXPECT_EQ(hands.options().zoom, 1);
    const std::vector<HandLook> looks = hands.looks();
    ASSERT_EQ(looks.size(), 1u);
    EXPECT_GT(looks[0].opacity, 0.9f) << "it was not lost";
}

}  // namespace
}  // namespace knead
