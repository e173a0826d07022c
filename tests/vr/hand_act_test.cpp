// Pinches, fists, rings and rays of tracked hands and of controllers.
#include "host/vr/hand_act.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/hands/posture.h"
#include "xr/hand_shape.h"

namespace knead {
namespace {

Hand hand_of(Side side, const Fingers& fingers, Vec3<double> at = {0, 0, 0})
{
    const Pose pose = posed(side, {{1, 0, 0, 0}, at}, fingers);
    const Hand usual = open_hand(side);
    Hand hand;
    for (std::size_t j = 0; j < joint_count; ++j)
        hand.joints[j] = {cast<float>(pose[j].q), cast<float>(pose[j].p)};
    hand.radius = usual.radius;
    hand.tracked = true;
    hand.valid.fill(true);
    return hand;
}
TrackedHand seen(const Hand& hand)
{
    TrackedHand found;
    found.hand = hand, found.from = HandFrom::cameras;
    return found;
}
TrackedHand controller(Side side, float trigger, float grasp)
{
    TrackedHand found;
    found.hand = xr::hand_around(side, {{1, 0, 0, 0}, {0, 0, 0}}, trigger, grasp);
    found.from = HandFrom::posed, found.pinch = trigger, found.grasp = grasp, found.holds = true;
    return found;
}
constexpr Joint<float> head_pose{{1, 0, 0, 0}, {0, 0.4f, 0.5f}};

TEST(HandAct, TellsAPinchFromAnOpenHandAndAFist)
{
    for (const Side side : {left, right}) {
        HandReader reader;
        const auto act = [&](const Fingers& fingers) {
            return reader.frame(side, seen(hand_of(side, fingers)), head_pose);
        };
        EXPECT_FALSE(act(gripped(0)).pinches || act(gripped(0)).fist);
        const HandAct pinch = act(pinched(side));
        EXPECT_TRUE(pinch.pinches) << *tips_apart(hand_of(side, pinched(side)));
        EXPECT_FALSE(pinch.fist);
        const HandAct fist = act(gripped(1));
        EXPECT_TRUE(fist.fist);
        EXPECT_FALSE(fist.pinches) << *tips_apart(hand_of(side, gripped(1)));
        EXPECT_FALSE(act(gripped(0)).fist);
    }
}

TEST(HandAct, APinchOpensFartherThanItCloses)
{
    HandReader reader;
    Hand hand = hand_of(right, gripped(0));
    const auto apart = [&](float by) {
        hand.joints[thumb_tip].p = hand.joints[index_tip].p + Vec3<float>{by, 0, 0};
        return reader.frame(right, seen(hand), head_pose).pinches;
    };
    EXPECT_FALSE(apart(0.03f));
    EXPECT_TRUE(apart(0.02f));
    EXPECT_TRUE(apart(0.03f));
    EXPECT_FALSE(apart(0.036f));
    hand.valid[thumb_tip] = false;
    EXPECT_FALSE(apart(0.01f)) << "nobody knows";
    hand.tracked = false;
    EXPECT_FALSE(reader.frame(right, seen(hand), head_pose).tracked);
}

TEST(HandAct, ATriggerPinchesAndAGripMakesAFist)
{
    for (const Side side : {left, right}) {
        HandReader reader;
        const auto act = [&](float trigger, float grasp) {
            return reader.frame(side, controller(side, trigger, grasp), head_pose);
        };
        const HandAct open = act(0, 0);
        EXPECT_TRUE(open.tracked && open.by_controller);
        EXPECT_FALSE(open.pinches || open.fist);
        const HandAct pulled = act(1, 0);
        EXPECT_TRUE(pulled.pinches);
        EXPECT_FALSE(pulled.fist);
        EXPECT_LT(length(pulled.at.p - open.at.p), 1e-6) << "pulling moves nothing";
        EXPECT_TRUE(act(0.5f, 0).pinches);
        EXPECT_FALSE(act(0.3f, 0).pinches);
        EXPECT_TRUE(act(1, 1).fist);
        EXPECT_FALSE(act(1, 1).pinches);
        EXPECT_FALSE(open.ring);
    }
}

TEST(HandAct, PointsAwayFromItsShoulderOrAsTheRuntimeSays)
{
    HandReader reader;
    TrackedHand found = seen(hand_of(right, gripped(0), {0.2, 0, 0}));
    const HandAct act = reader.frame(right, found, head_pose);
    EXPECT_NEAR(length(act.ray), 1, 1e-9);
    EXPECT_LT(act.ray.z, -0.8) << "forward";
    EXPECT_LT(std::abs(act.ray.x), 0.3);
    // A head that looks down, and a body that is turned.
    const auto q = [](Vec3<double> axis, double angle) {
        return cast<float>(turn_about(axis, angle));
    };
    const HandAct down = reader.frame(right, found, {q({1, 0, 0}, -0.6), head_pose.p});
    EXPECT_LT(length(down.ray - act.ray), 1e-6);
    found.aim = Joint<float>{q({0, 1, 0}, std::acos(-1.0) / 2), {0, 0, 0}};
    EXPECT_LT(length(reader.frame(right, found, head_pose).ray - Vec3<double>{-1, 0, 0}), 1e-6);
}

TEST(HandAct, ThumbAndIndexFormARing)
{
    for (const Side side : {left, right}) {
        const Hand small = hand_of(side, pinched(side), {0.3, 0.2, 0.1});
        const auto ring = finger_ring(small);
        ASSERT_TRUE(ring);
        EXPECT_GT(ring->diameter, 0.015);
        EXPECT_LT(ring->diameter, 0.07);
        EXPECT_NEAR(length(ring->axis), 1, 1e-9);
        // All joints are around the centre, near the plane.
        for (const JointName name : {thumb_distal, thumb_tip, index_tip, index_intermediate}) {
            const Vec3<double> d = cast<double>(small.joints[name].p) - ring->centre;
            EXPECT_LT(length(d), 0.06);
            EXPECT_LT(std::abs(dot(d, ring->axis)), 0.025);
        }
        // Twice the hand, twice the ring.
        Hand twice = small;
        for (auto& joint : twice.joints) joint.p = 2.f * joint.p;
        for (float& r : twice.radius) r *= 2;
        EXPECT_NEAR(finger_ring(twice)->diameter, 2 * ring->diameter, 1e-6);
        twice.valid[index_distal] = false;
        EXPECT_FALSE(finger_ring(twice));
    }
}

}  // namespace
}  // namespace knead
