// A hand's size is that of its bones and fingers, whatever its pose, its tracker's noise and what
// its tracker calls a radius; rigs and skins take it on.
#include "host/hands/hand_size.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "host/hands/filter.h"
#include "host/hands/gesture.h"
#include "host/hands/posture.h"

namespace knead {
namespace {

constexpr double step = 1.0 / 1024;  // of a size

Hand tracked(Hand hand)
{
    hand.tracked = true;
    hand.valid.fill(true);
    return hand;
}

// A hand in that pose whose bones are so much longer, and whose radii are so much larger.
Hand sized(Side side, const Fingers& fingers, double along, double radii)
{
    Hand hand = open_hand(side);
    const Pose pose = posed(side, {{0.6, 0, 0.8, 0}, {0.1, 1.2, -0.4}}, fingers);
    for (int j = 0; j < joint_count; ++j) {
        hand.joints[j] = cast<float>(pose[j]);
        hand.joints[j].p = float(along) * hand.joints[j].p;
        hand.radius[j] *= float(radii);
    }
    return tracked(hand);
}

Stretch<float> size_of(const Hand& hand)
{
    HandSize size;
    size.see(hand, 0);
    return size.stretch();
}

// What a Quest reports of the default hand from the wrist on, joint by joint [mm].
constexpr float quest[] = {21.5f, 19.4f, 12.3f, 9.8f, 8.8f, 21.2f, 10.3f, 8.5f, 7.6f,
                           6.6f,  21.2f, 11.2f, 8.0f, 7.6f, 6.6f,  19.1f, 9.9f, 7.6f,
                           7.2f,  6.2f,  18.1f, 8.5f, 6.8f, 6.4f,  5.4f};

TEST(HandSize, OfADefaultHandIsExactlyOneInAnyPose)
{
    for (const Side side : {left, right})
        for (const double closed : {0.0, 0.3, 1.0}) {
            const Stretch<float> s = size_of(sized(side, gripped(closed), 1, 1));
            EXPECT_EQ(s.across, 1);
            EXPECT_EQ(s.along, 1);
        }
}

TEST(HandSize, OfAHandThatIsLargerOrSmallerIsItsOwn)
{
    for (const double k : {0.7, 0.9, 1.15, 1.4}) {
        const Stretch<float> s = size_of(sized(left, gripped(0.4), k, k));
        EXPECT_NEAR(s.across, k, step);
        EXPECT_NEAR(s.along, k, step);
    }
}

TEST(HandSize, OfThinAndThickFingersIsAsTheirRadiiAre)
{
    const Stretch<float> thin = size_of(sized(right, Fingers{}, 1.1, 0.9));
    EXPECT_NEAR(thin.along, 1.1, step);
    EXPECT_NEAR(thin.across, 0.9, step);
    // 1.3 is 11 % above what any tracker calls the radii of the default hand.
    const Stretch<float> thick = size_of(sized(right, Fingers{}, 1, 1.3));
    EXPECT_NEAR(thick.along, 1, step);
    EXPECT_GT(thick.across, 1.05);
    EXPECT_LT(thick.across, 1.12);
}

TEST(HandSize, IsTheSameForATrackerWhoseRadiiAreLarger)
{
    for (const float k : {0.8f, 1.0f, 1.25f}) {
        Hand hand = sized(right, gripped(0.2), double(k), 1);
        for (int j = wrist; j < joint_count; ++j) hand.radius[j] = 1e-3f * k * quest[j - wrist];
        EXPECT_NEAR(size_of(hand).across, k, 2 * step);
        EXPECT_NEAR(size_of(hand).along, k, step);
    }
}

TEST(HandSize, GoesByTheBonesWhereRadiiAreUnknown)
{
    for (const float radius : {0.0f, 0.01f, -1.0f, 0.5f, std::numeric_limits<float>::quiet_NaN()}) {
        Hand hand = sized(left, Fingers{}, 0.85, 1);
        hand.radius.fill(radius);
        EXPECT_NEAR(size_of(hand).across, 0.85, step);
        EXPECT_NEAR(size_of(hand).along, 0.85, step);
    }
}

TEST(HandSize, StaysWithinWhatHandsAre)
{
    for (const double k : {0.01, 50.0}) {
        const Stretch<float> s = size_of(sized(left, Fingers{}, k, 1 / k));
        for (const float x : {s.across, s.along}) EXPECT_TRUE(x > 0.4f && x < 2.1f) << x;
    }
}

TEST(HandSize, IsNotMovedByWhatIsMissing)
{
    HandSize size;
    for (int i = 0; i < 20; ++i) size.see(sized(left, Fingers{}, 1.2, 1.2), 0.02);
    Hand lost = sized(left, Fingers{}, 0.7, 0.7);
    lost.valid[ring_distal] = false;
    Hand far = sized(left, Fingers{}, 0.7, 0.7);
    far.joints[thumb_distal].p.x = std::numeric_limits<float>::infinity();
    for (int i = 0; i < 200; ++i) size.see(i % 2 ? lost : far, 0.02);
    size.see(sized(left, Fingers{}, 0.7, 0.7), std::nan(""));
    EXPECT_NEAR(size.stretch().along, 1.2, step);
    EXPECT_NEAR(size.stretch().across, 1.2, step);
}

// Noise makes bones longer, by its variance over their length: 2.25 mm^2 / 30 mm here.
TEST(HandSize, IsCalmInNoiseAndFollowsAnotherUsersHand)
{
    std::mt19937 source(5);
    std::normal_distribution<float> noise(0, 1.5e-3f);
    const auto shaken = [&](double k) {
        Hand hand = sized(right, gripped(0.3), k, k);
        for (auto& joint : hand.joints)
            joint.p = joint.p + Vec3<float>{noise(source), noise(source), noise(source)};
        return hand;
    };
    HandSize size;
    float low = 2, high = 0;
    for (int i = 0; i < 720; ++i) {
        size.see(shaken(1.1), 1 / 72.0);
        if (i < 72) continue;
        low = std::min(low, size.stretch().along), high = std::max(high, size.stretch().along);
    }
    EXPECT_GT(low, 1.095);
    EXPECT_LT(high, 1.12);
    for (int i = 0; i < 720; ++i) size.see(shaken(0.8), 1 / 72.0);
    EXPECT_NEAR(size.stretch().along, 0.8, 0.02);
}

// Over the whole way: from frames through filter and stream to the time that is asked for.
TEST(HandSize, ComesWithTheStream)
{
    HandStream stream({});
    EXPECT_EQ(stream.stretch(1, left).along, 1);
    for (int i = 0; i < 60; ++i) {
        HandFrame frame;
        frame.time = i / 60.0;
        frame.hand[left] = sized(left, Fingers{}, 1.2, 1.2);
        frame.hand[right] = sized(right, Fingers{}, 0.8, 0.8);
        if (i > 30) frame.hand[left].tracked = false;
        stream.push(frame);
    }
    for (const double time : {0.1, 0.4, 0.9}) {
        EXPECT_NEAR(stream.stretch(time, left).along, 1.2, step);
        EXPECT_NEAR(stream.stretch(time, right).across, 0.8, step);
    }
}

TEST(HandSize, OfGeneratedHandsIsOne)
{
    for (const char* name : {"squeeze", "pinch"}) {
        const HandSource hands(generate(name, {}), {});
        for (const Side side : {left, right}) {
            EXPECT_EQ(hands.stretch(1, side).along, 1) << name;
            EXPECT_EQ(hands.stretch(1, side).across, 1) << name;
        }
    }
}

// All of a hand that is k times as large in every way is k times as large, bent, too.
TEST(HandSize, StretchesARigAsAWhole)
{
    constexpr float k = 1.25f;
    for (const Topology topology : {Topology::h25, Topology::h47}) {
        const Hand usual = sized(left, gripped(0.5), 1, 1), large = sized(left, gripped(0.5), k, k);
        for (const Binding<float>& b : hand_rig(topology, left).spheres) {
            const auto of = [](const Hand& hand) {
                return [&hand](int j) { return hand.joints[std::size_t(j)]; };
            };
            const Binding<float> s = stretched(b, {k, k});
            EXPECT_LT(length(centre(s, of(large)) - k * centre(b, of(usual))), 1e-6f);
            EXPECT_FLOAT_EQ(s.radius, k * b.radius);
        }
    }
}

}  // namespace
}  // namespace knead
