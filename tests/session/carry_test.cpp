// Fists that carry clay as a whole, and two that zoom.
#include "host/session/carry.h"

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

TEST(Carry, carries_clay_with_the_fist_that_closed_on_it)
{
    Carry hold;
    HandFrame hands;
    hands.hand[right] = hand_at(right, {0.02, 0, 0}, 0);
    EXPECT_FALSE(hold.frame(hands, options(), clay()).category);
    hands.hand[right] = hand_at(right, {0.02, 0, 0}, 1);
    const auto took = hold.frame(hands, options(), clay());
    ASSERT_TRUE(took.category);
    EXPECT_EQ(*took.category, 3);
    EXPECT_TRUE(took.took);
    EXPECT_LT(length(took.motion.p), 1e-6) << "it does not leap";

    hands.hand[right] = hand_at(right, {0.02, 0.1, 0}, 1, 0.5);
    const auto moved = hold.frame(hands, options(), clay());
    ASSERT_TRUE(moved.category);
    EXPECT_FALSE(moved.took);
    // What was in the palm stays in the palm: at + zoom * palm.
    const Vec3<double> before{1.04, 1, 1}, after{1.04, 1.2, 1};
    EXPECT_LT(length(rotate(moved.motion.q, before) + moved.motion.p - after), 1e-6);
    EXPECT_NEAR(moved.motion.q.y, std::sin(0.25), 1e-5);

    hands.hand[right] = hand_at(right, {0.02, 0.1, 0}, 0);
    const auto freed = hold.frame(hands, options(), clay());
    EXPECT_TRUE(freed.let_go);
    EXPECT_FALSE(freed.category);
    EXPECT_FALSE(hold.frame(hands, options(), clay()).let_go);
}

TEST(Carry, takes_nothing_that_is_out_of_reach_and_lets_go_where_a_hand_is_lost)
{
    Carry hold;
    HandFrame hands;
    hands.hand[left] = hand_at(left, {0.3, 0, 0}, 1);
    EXPECT_FALSE(hold.frame(hands, options(), clay()).category);
    EXPECT_FALSE(hold.frame(hands, options(), {}).category) << "no clay at all";
    hands.hand[left] = hand_at(left, {0.02, 0, 0}, 1);
    EXPECT_TRUE(hold.frame(hands, options(), clay()).category);
    hands.hand[left].tracked = false;
    EXPECT_TRUE(hold.frame(hands, options(), clay()).let_go);
}

TEST(Carry, zooms_by_the_way_between_two_fists)
{
    Carry hold;
    HandFrame hands;
    hands.hand[left] = hand_at(left, {-0.4, 0.3, 0}, 1);
    hands.hand[right] = hand_at(right, {0.4, 0.3, 0}, 1);
    EXPECT_EQ(hold.frame(hands, options(), clay()).zoom, 1);
    hands.hand[right] = hand_at(right, {0.48, 0.3, 0}, 1);
    EXPECT_NEAR(hold.frame(hands, options(), clay()).zoom, 1.1, 1e-4);
    hands.hand[right] = hand_at(right, {9, 0.3, 0}, 1);
    EXPECT_EQ(hold.frame(hands, options(), clay()).zoom, 1.25) << "a leap is bounded";
    hands.hand[right] = hand_at(right, {9, 0.3, 0}, 0);
    EXPECT_EQ(hold.frame(hands, options(), clay()).zoom, 1);
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
