// A hand that hangs on a mouse: where it is, how it presses, and that it is a tracked hand.
#include "host/hands/pointer.h"

#include <gtest/gtest.h>

#include "host/hands/filter.h"
#include "host/hands/recording.h"

namespace knead {
namespace {

// Looking along -z from (0.5, 0.3, 2).
Pointing ahead()
{
    Pointing p;
    p.eye = {0.5, 0.3, 2};
    p.ray = {0.1, 0, -1};
    return p;
}

HandsOptions zoomed()
{
    HandsOptions options;
    options.zoom = 2.5;
    options.at = {0.5, 0.3, 0.5};
    return options;
}

// The least z of the tool in the simulation.
double foremost_z(const HandFrame& frame, const HandsOptions& options)
{
    const std::string& held = options.held[right];
    const Rig rig = held.empty() ? hand_rig(options.topology, right) : tool_rig(held, right);
    double least = 1e30;
    for (const Binding<float>& b : rig.spheres) {
        const Vec3<float> c = centre(b, [&](int j) {
            return frame.hand[right].joints[std::size_t(j - int(right) * joint_count)];
        });
        least = std::min(least, options.at.z + options.zoom * double(c.z - b.radius));
    }
    return least;
}

TEST(PointerHand, ItsForemostPointIsWhereTheMousePoints)
{
    for (const char* held : {"", "knife", "ball", "slab"})
        for (int posture = 0; posture < posture_count; ++posture) {
            PointerHand hand;
            hand.posture = Posture(posture);
            hand.reach = 1.2, hand.tilt = 0.3, hand.roll = -0.4;
            HandsOptions options = zoomed();
            options.held[right] = held;
            hand.advance(1);
            const HandFrame frame = hand.hands(ahead(), options);
            EXPECT_NEAR(foremost_z(frame, options), 2 - 1.2, 1e-5) << held << posture;
            EXPECT_EQ(frame.time, 1);
            EXPECT_TRUE(frame.hand[right].tracked);
            EXPECT_FALSE(frame.hand[left].tracked);
        }
}

TEST(PointerHand, PressesInSmoothlyAndComesBack)
{
    PointerHand hand;
    hand.press = 0.1;
    const HandsOptions options = zoomed();
    const auto z = [&](double time) {
        hand.advance(time);
        return foremost_z(hand.hands(ahead(), options), options);
    };
    const double rest = z(0);
    hand.pressed = true;
    double before = rest, most = 0;
    for (int i = 1; i <= 40; ++i) {
        const double now = z(0.01 * i);
        EXPECT_LE(now, before + 1e-6);
        most = std::max(most, before - now);
        before = now;
    }
    EXPECT_NEAR(before, rest - 0.1 * 2.5, 1e-5);
    EXPECT_LT(most / 0.01, 2.5 * 0.1 / 0.25 * 2) << "no faster than twice the mean";
    hand.pressed = false;
    EXPECT_NEAR(z(1), rest, 1e-5);
}

TEST(PointerHand, FingersCurlWithinTheirLimits)
{
    PointerHand hand;
    hand.posture = Posture::open;
    EXPECT_EQ(hand.fingers().flex[1][0], 0);
    hand.curl[1] = 1;
    EXPECT_NEAR(hand.fingers().flex[1][0], gripped(1).flex[1][0], 1e-12);
    EXPECT_EQ(hand.fingers().flex[2][0], 0);
    hand.curl[1] = 100;
    EXPECT_NEAR(hand.fingers().flex[1][0], gripped(1).flex[1][0], 1e-12);
}

// As a recording it is one that files hold, and filters find it steady.
TEST(PointerHand, IsATrackedHandLikeAnyOther)
{
    PointerHand hand;
    Recording recording;
    recording.name = "mouse", recording.rate = 60;
    HandStream stream(zoomed());
    for (int i = 0; i < 60; ++i) {
        hand.advance(i / 60.0);
        recording.frames.push_back(hand.hands(ahead(), zoomed()));
        stream.push(recording.frames.back());
    }
    EXPECT_NO_THROW(check(recording));
    Joint<double> joints[2 * joint_count];
    float size[side_count];
    EXPECT_TRUE(stream.sample(0.95, joints, size));
    EXPECT_EQ(size[right], 1);
}

}  // namespace
}  // namespace knead
