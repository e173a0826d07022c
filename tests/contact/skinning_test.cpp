#include <gtest/gtest.h>

#include <set>
#include <string>

#include "host/assets/skin.h"
#include "host/hands/hands.h"

namespace knead {
namespace {

// First and last joint of each finger's moving bones.
constexpr int chains[5][2] = {{thumb_metacarpal, thumb_tip},
                              {index_proximal, index_tip},
                              {middle_proximal, middle_tip},
                              {ring_proximal, ring_tip},
                              {little_proximal, little_tip}};

float separation(const Hand& hand, int a, int b)
{
    return length(hand.joints[a].p - hand.joints[b].p);
}

TEST(OpenHand, NamesEveryJointOnceAsTheEnumerationSpellsIt)
{
    const std::set<std::string> names(joint_names, joint_names + joint_count);
    EXPECT_EQ(names.size(), std::size_t(joint_count));
    EXPECT_EQ(joint_names[palm], std::string("palm"));
    EXPECT_EQ(joint_names[thumb_tip], std::string("thumb_tip"));
    EXPECT_EQ(joint_names[index_intermediate], std::string("index_intermediate"));
    EXPECT_EQ(joint_names[little_tip], std::string("little_tip"));
}

TEST(OpenHand, LiesPalmDownWithItsFingersAheadAndItsThumbInwards)
{
    for (const Side side : {left, right}) {
        const Hand hand = open_hand(side);
        const float outwards = side == right ? 1.f : -1.f;
        EXPECT_EQ(length(hand.joints[wrist].p), 0);
        EXPECT_NEAR(separation(hand, wrist, middle_tip), 0.18f, 0.005f);
        for (const int tip : {index_tip, middle_tip, ring_tip, little_tip})
            EXPECT_LT(hand.joints[tip].p.z, -0.13f);
        for (int j = 0; j < joint_count; ++j)
            EXPECT_GT(rotate(hand.joints[j].q, Vec3<float>{0, 1, 0}).y, 0.2f) << joint_names[j];
        EXPECT_LT(outwards * hand.joints[thumb_tip].p.x, -0.06f);
        EXPECT_GT(outwards * hand.joints[little_tip].p.x, 0.04f);
    }
}

TEST(OpenHand, IsTrackedAndHasPositiveRadii)
{
    for (const Side side : {left, right}) {
        const Hand hand = open_hand(side);
        EXPECT_TRUE(hand.tracked);
        for (int j = 0; j < joint_count; ++j) {
            EXPECT_TRUE(hand.valid[j]);
            EXPECT_GT(hand.radius[j], 0.004f) << joint_names[j];
            EXPECT_LT(hand.radius[j], 0.025f) << joint_names[j];
            const Quat<float> q = hand.joints[j].q;
            EXPECT_NEAR(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z, 1, 1e-6f);
        }
    }
}

TEST(OpenHand, PointsEveryBoneBackwardsAlongItsOwnZ)
{
    const Hand hand = open_hand(right);
    for (const auto& chain : chains)
        for (int j = chain[0]; j < chain[1]; ++j) {
            const Vec3<float> bone = hand.joints[j].p - hand.joints[j + 1].p;
            const Vec3<float> z = rotate(hand.joints[j].q, Vec3<float>{0, 0, 1});
            EXPECT_GT(dot(bone, z), 0.99999f * length(bone)) << joint_names[j];
        }
    for (const int j : {index_metacarpal, middle_metacarpal, ring_metacarpal, little_metacarpal}) {
        const Vec3<float> bone = hand.joints[j].p - hand.joints[j + 1].p;
        const Vec3<float> z = rotate(hand.joints[j].q, Vec3<float>{0, 0, 1});
        EXPECT_GT(dot(bone, z), 0.99f * length(bone)) << joint_names[j];
    }
}

TEST(OpenHand, SharesOneFlexionAxisAlongEachFinger)
{
    const Hand hand = open_hand(right);
    for (const auto& chain : chains)
        for (int j = chain[0]; j + 1 < chain[1]; ++j) {
            const Vec3<float> x = rotate(hand.joints[j].q, Vec3<float>{1, 0, 0});
            const Vec3<float> next = rotate(hand.joints[j + 1].q, Vec3<float>{1, 0, 0});
            EXPECT_GT(dot(x, next), 0.985f) << joint_names[j];
        }
}

// A negative turn about local x brings a fingertip below the palm, on both hands.
TEST(OpenHand, FlexesTowardsThePalmByNegativeTurnsAboutX)
{
    for (const Side side : {left, right}) {
        const Hand hand = open_hand(side);
        for (const int finger : {index_proximal, middle_proximal, ring_proximal, little_proximal}) {
            const Joint<float> joint = hand.joints[finger];
            const Vec3<float> tip = rotate(conjugate(joint.q), hand.joints[finger + 3].p - joint.p);
            const Quat<float> bent = joint.q * turn_about(Vec3<float>{1, 0, 0}, -1.5f);
            EXPECT_LT((joint.p + rotate(bent, tip)).y, joint.p.y - 0.05f) << joint_names[finger];
        }
    }
}

TEST(OpenHand, MirrorsLeftAndRight)
{
    const Hand one = open_hand(left), other = open_hand(right);
    for (int j = 0; j < joint_count; ++j) {
        const Vec3<float> p = one.joints[j].p, m = other.joints[j].p;
        EXPECT_EQ(p.x, -m.x);
        EXPECT_EQ(p.y, m.y);
        EXPECT_EQ(p.z, m.z);
        EXPECT_EQ(one.radius[j], other.radius[j]);
        // y and z are reflected; x is reflected and turned about, so that the frame stays
        // right-handed.
        for (const Vec3<float> axis : {Vec3<float>{0, 1, 0}, Vec3<float>{0, 0, 1}}) {
            const Vec3<float> u = rotate(one.joints[j].q, axis),
                              v = rotate(other.joints[j].q, axis);
            EXPECT_NEAR(length(u - Vec3<float>{-v.x, v.y, v.z}), 0, 1e-6f);
        }
    }
}

TEST(OpenHand, PutsThePalmAmidTheMiddleMetacarpal)
{
    const Hand hand = open_hand(right);
    const Vec3<float> middle =
        0.5f * (hand.joints[middle_metacarpal].p + hand.joints[middle_proximal].p);
    EXPECT_NEAR(length(hand.joints[palm].p - middle), 0, 2e-5f);
}

}  // namespace
}  // namespace knead
