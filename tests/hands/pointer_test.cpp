// A hand that hangs on a mouse: where it is, how it presses, and that it is a tracked hand.
#include "host/hands/pointer.h"

#include <gtest/gtest.h>

#include "host/hands/filter.h"
#include "host/hands/recording.h"

namespace knead {
namespace {

Vec3<double> unit_of(Vec3<double> v) { return (1 / length(v)) * v; }

// Looking along -z from (0.5, 0.3, 2) at a wall, whose normal leans to one side.
Pointing ahead(double lean = 0)
{
    Pointing p;
    p.eye = {0.5, 0.3, 2};
    p.ray = {0.1, 0, -1};
    p.middle = {0.5, 0.3, 0.8};
    p.on = SurfacePoint{{0.62, 0.3, 0.8}, unit_of({lean, 0.2, 1})};
    return p;
}

HandsOptions zoomed()
{
    HandsOptions options;
    options.zoom = 2.5;
    options.at = {0.5, 0.3, 0.5};
    return options;
}

// Of the hand's spheres, or of the tool's, in the simulation.
template <class Each>
void each_sphere(const HandFrame& frame, const HandsOptions& options, const Each& each)
{
    const std::string& held = options.held[right];
    const Rig rig = held.empty() ? hand_rig(options.topology, right) : tool_rig(held, right);
    for (const Binding<float>& b : rig.spheres) {
        const Vec3<float> c = centre(b, [&](int j) {
            return frame.hand[right].joints[std::size_t(j - int(right) * joint_count)];
        });
        each(options.at + options.zoom * cast<double>(c), options.zoom * double(b.radius));
    }
}

// How far the foremost point is beyond the target in the direction of the press [m].
double depth_of(const PointerHand& hand, const HandsOptions& options)
{
    double most = -1e30;
    each_sphere(hand.hands(options), options, [&](Vec3<double> c, double radius) {
        most = std::max(most, dot(c - hand.target(), hand.direction()) + radius);
    });
    return most;
}

TEST(PointerHand, RestsBesideTheSurfaceThatTheMousePointsAt)
{
    for (const char* held : {"", "knife", "ball", "slab"})
        for (int posture = 0; posture < posture_count; ++posture)
            for (const double lean : {-0.8, 0.0, 3.0}) {
                PointerHand hand;
                hand.posture = Posture(posture);
                hand.gap = 0.04, hand.tilt = 0.3, hand.roll = -0.4;
                HandsOptions options = zoomed();
                options.held[right] = held;
                hand.aim(ahead(lean));
                hand.advance(1);
                EXPECT_NEAR(depth_of(hand, options), -0.04, 1e-5) << held << posture;
                EXPECT_NEAR(length(hand.target() - ahead().on->at), 0, 1e-12);
                EXPECT_LT(dot(hand.direction(), ahead(lean).on->normal), 0) << "into the clay";
                const HandFrame frame = hand.hands(options);
                EXPECT_EQ(frame.time, 1);
                EXPECT_FALSE(frame.hand[right].tracked) << "on its way it shapes nothing";
                EXPECT_FALSE(frame.hand[left].tracked);
            }
}

// The forearm leaves to the side, of the half of the picture in which the pointer is, and the line
// of sight to the place is free but for the finger that presses.
TEST(PointerHand, DoesNotHideWhatItPresses)
{
    for (const double at : {-0.4, 0.4}) {
        PointerHand hand;
        Pointing p = ahead();
        p.ray = {at, 0, -1};
        p.on->at = p.eye + 1.2 * p.ray;
        hand.aim(p);
        hand.advance(0);
        const HandsOptions options = zoomed();
        const HandFrame frame = hand.hands(options);
        const Vec3<double> arm =
            options.at + options.zoom * cast<double>(frame.hand[right].joints[wrist].p);
        EXPECT_GT((arm.x - p.on->at.x) * at, 0.15 * 0.4);
        int before = 0;
        each_sphere(frame, options, [&](Vec3<double> c, double radius) {
            const Vec3<double> along = unit_of(p.ray), to = c - p.eye;
            before += length(to - dot(to, along) * along) < radius;
        });
        EXPECT_LE(before, 2);
    }
}

TEST(PointerHand, PressesInSmoothlyAndComesBack)
{
    PointerHand hand;
    hand.press = 0.1, hand.gap = 0.02;
    const HandsOptions options = zoomed();
    const auto depth = [&](double time) {
        hand.aim(ahead());
        hand.advance(time);
        return depth_of(hand, options);
    };
    depth(0);
    hand.pressed = true;
    double before = -0.02, most = 0;
    for (int i = 1; i <= 60; ++i) {
        const double now = depth(0.01 * i);
        EXPECT_TRUE(hand.hands(options).hand[right].tracked);
        EXPECT_GE(now, before - 1e-6);
        if (0.01 * i < PointerHand::appear_time) {
            EXPECT_NEAR(now, -0.02, 1e-5);
        }
        most = std::max(most, now - before);
        before = now;
    }
    EXPECT_NEAR(before, 0.1, 1e-5);
    EXPECT_LT(most / 0.01, 0.12 / 0.25 * 2) << "no faster than twice the mean";
    hand.pressed = false;
    EXPECT_NEAR(depth(1), -0.02, 1e-5);
    EXPECT_FALSE(hand.hands(options).hand[right].tracked);
}

TEST(PointerHand, AClickIsAWholePress)
{
    PointerHand hand;
    hand.aim(ahead());
    hand.advance(0);
    hand.pressed = true;
    hand.advance(0.01);
    hand.pressed = false;
    double most = -1;
    for (int i = 2; i < 100; ++i) {
        hand.aim(ahead());
        hand.advance(0.01 * i);
        most = std::max(most, depth_of(hand, zoomed()));
    }
    EXPECT_NEAR(most, hand.press, 0.002);
    EXPECT_FALSE(hand.presses());
}

// While it presses, it goes sideways with the mouse, and not after the surface that it deforms.
TEST(PointerHand, ADragKeepsDistanceAndDirection)
{
    PointerHand hand;
    hand.aim(ahead());
    hand.advance(0);
    hand.pressed = true;
    hand.advance(1), hand.advance(2);
    const Vec3<double> direction = hand.direction();
    Pointing p = ahead(2);
    p.ray = {-0.2, 0.1, -1};
    p.on->at = p.eye + 2.0 * p.ray;
    hand.aim(p);
    hand.advance(2.1);
    EXPECT_NEAR(length(hand.target() - (p.eye + 1.2 * p.ray)), 0, 1e-12);
    EXPECT_EQ(length(hand.direction() - direction), 0);
    hand.cancel();
    EXPECT_FALSE(hand.presses());
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
    hand.pressed = true;
    for (int i = 0; i < 60; ++i) {
        hand.aim(ahead());
        hand.advance(i / 60.0);
        recording.frames.push_back(hand.hands(zoomed()));
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
