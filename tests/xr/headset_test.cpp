// Pure parts of a headset's session: places, times, fading hands.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/hands/motion.h"
#include "host/scene/seed.h"
#include "host/vr/headset_hands.h"
#include "host/vr/headset_time.h"
#include "render/hand_skin.h"
#include "render/pace.h"

namespace knead {
namespace {

TEST(Workplace, at_the_origin_changes_no_bit_of_a_hand)
{
    Hand hand = open_hand(right);
    hand.valid.fill(true);
    for (int j = 0; j < joint_count; ++j) hand.joints[j].p.x += 0.123f * float(j);
    const Hand same = in_hands(Workplace{{0, 0, 0}, 0}, hand);
    for (int j = 0; j < joint_count; ++j) {
        EXPECT_EQ(same.joints[j].p.x, hand.joints[j].p.x);
        EXPECT_EQ(same.joints[j].p.z, hand.joints[j].p.z);
        EXPECT_EQ(same.joints[j].q.w, hand.joints[j].q.w);
        EXPECT_EQ(same.joints[j].q.y, hand.joints[j].q.y);
    }
}

TEST(Workplace, before_a_head_is_where_it_usually_is_before_the_origin)
{
    const Workplace usual{{0.1, -0.35, -0.5}, 0};
    const Workplace same = before_head({{1, 0, 0, 0}, {0, 0, 0}}, usual);
    EXPECT_LT(length(same.at - usual.at), 1e-9);
    // A head turned by a quarter to the left, up, and bent down.
    const double quarter = std::numbers::pi / 2;
    const Quat<double> turn = turn_about(Vec3<double>{0, 1, 0}, quarter);
    const Quat<double> bend = turn_about(Vec3<double>{1, 0, 0}, -0.4);
    const Joint<float> head{cast<float>(turn * bend), {1, 1.6f, 2}};
    const Workplace place = before_head(head, usual);
    EXPECT_NEAR(place.turn, quarter, 1e-6);
    EXPECT_LT(length(place.at - Vec3<double>{0.5, 1.25, 1.9}), 1e-6);
    // The head, as the hands' frame sees it, is where it usually is.
    const Joint<float> seen = in_hands(place, head);
    EXPECT_LT(length(cast<double>(seen.p) + usual.at), 1e-6);
    EXPECT_NEAR(rotate(seen.q, Vec3<float>{0, 0, -1}).x, 0, 1e-6);
}

TEST(Workplace, eyes_stand_in_the_simulation_as_hands_do)
{
    const Workplace place{{0.2, -0.3, -0.4}, 0.7};
    HandsOptions options;
    options.zoom = 2.5, options.at = {0.5, 0.3, 0.5};
    EyePlace eye{{{1, 0, 0, 0}, {0.03f, 0.1f, 0.2f}}, {-0.8f, 0.7f, 0.75f, -0.85f}};
    const EyeView view = eye_view(eye, 640, 480, place, options, 0.05f);
    const Joint<float> hand = in_hands(place, eye.pose);
    EXPECT_LT(length(view.position - (cast<float>(options.at) + 2.5f * hand.p)), 1e-6f);
    EXPECT_FLOAT_EQ(view.near, 0.125f);
    EXPECT_FLOAT_EQ(view.left, std::tan(-0.8f));
    EXPECT_FLOAT_EQ(view.down, std::tan(-0.85f));
    EXPECT_EQ(view.width, 640);
}

TEST(LiveHands, of_a_scene_without_any_are_as_large_as_its_clay_wants)
{
    Scene scene{};
    Object ball;
    ball.centre = {0.5, 0.3, 0.5}, ball.size = {0.4, 0.4, 0.4};
    scene.objects = {ball};
    const HandsOptions options = live_hands(scene);
    EXPECT_DOUBLE_EQ(options.zoom, 2);
    EXPECT_LT(length(options.at - ball.centre), 1e-12);
    scene.has_hands = true;
    scene.hands.zoom = 7;
    EXPECT_EQ(live_hands(scene).zoom, 7);
}

TEST(LiveHands, of_a_table_without_objects_reach_all_of_it)
{
    Scene scene{};
    scene.stated_cells = {64, 64, 64}, scene.setup.lattice.dx = 1.0 / 64;
    scene.setup.walls.min = {0.1, 0.1, 0.1}, scene.setup.walls.max = {0.9, 0.9, 0.9};
    const HandsOptions options = live_hands(scene);
    EXPECT_DOUBLE_EQ(options.zoom, 2.5);
    EXPECT_LT(length(options.at - Vec3<double>{0.5, 0.35, 0.5}), 1e-12);
}

TEST(SessionTime, is_on_the_ends_of_frames_to_the_bit_and_stands_still_unseen)
{
    SessionTime time(90);
    EXPECT_EQ(time.frame(5.0, false), 0);
    for (int k = 1; k < 1000; ++k)
        EXPECT_EQ(time.frame(5.0 + 1e-9 * std::round(k * 1e9 / 90), true), k / 90.0);
    const double last = time.time();
    EXPECT_EQ(time.frame(100, false), last) << "nobody has seen the time until then";
    EXPECT_NEAR(time.frame(100 + 1.0 / 72, true), last + 1.0 / 72, 1e-9);
    EXPECT_NEAR(time.frame(99, true), last + 1.0 / 72, 1e-9) << "it never goes back";
}

TEST(DisplayClock, goes_on_with_the_wall_for_one_frame)
{
    DisplayClock clock;
    clock.set(3, 100, 0.01);
    EXPECT_DOUBLE_EQ(clock.now(100), 3);
    EXPECT_NEAR(clock.now(100.004), 3.004, 1e-9);
    EXPECT_DOUBLE_EQ(clock.now(200), 3.01);
    EXPECT_DOUBLE_EQ(clock.now(99), 3);
    clock.set(3, 100, 0);
    EXPECT_DOUBLE_EQ(clock.now(200), 3) << "without frames it stands still";
}

TEST(HandFade, takes_its_time_in_both_directions)
{
    HandFade fade;
    EXPECT_EQ(fade.frame(0, false, 0), 0);
    EXPECT_EQ(fade.frame(1, true, 0), HandFade::faint) << "seen, but not to be felt yet";
    EXPECT_EQ(fade.frame(2, true, 1), 1);
    const float soon = fade.frame(2 + HandFade::fading / 2, false, 0);
    EXPECT_GT(soon, 0.4f);
    EXPECT_LT(soon, 0.6f);
    EXPECT_EQ(fade.frame(2 + 2 * HandFade::fading, false, 0), 0);
}

// Of a renderer whose time goes with the pixels.
TEST(Pace, comes_to_rest_where_pictures_are_in_time)
{
    for (const double whole : {0.2, 0.9, 1.15, 1.5, 3.0, 9.0, 100.0}) {  // of the budget
        Pace pace(1, 0.3, 1);
        for (int k = 0; k < 30; ++k) pace.took(whole * pace.scale() * pace.scale());
        const double rests_at = pace.scale(), takes = whole * rests_at * rests_at;
        EXPECT_LE(takes, std::max(1.2, whole * 0.09 + 1e-9)) << whole;
        if (rests_at < 1 && rests_at > 0.3) {
            EXPECT_GE(takes, 0.6) << whole;
        }
        pace.took(takes);
        EXPECT_EQ(pace.scale(), rests_at) << whole;
        for (int k = 0; k < 30; ++k) pace.took(0.1 * pace.scale() * pace.scale());
        EXPECT_EQ(pace.scale(), 1) << "it comes back";
    }
}

TEST(Pace, has_its_pixels_back_where_fewer_take_no_less)
{
    // Splats that crowd into few tiles: half the side takes twice the time.
    Pace pace(1, 0.125, 1);
    double least = 1;
    int coarse = 0;
    for (int frame = 0; frame < 1000; ++frame) {
        pace.took(2 / pace.scale());
        least = std::min(least, pace.scale());
        coarse += pace.scale() < 1;
    }
    EXPECT_GT(least, 0.6);  // one step down
    EXPECT_LT(coarse, 50);
    // When they take as long as they have pixels, the side falls again.
    for (int frame = 0; frame < 200; ++frame) pace.took(3 * pace.scale() * pace.scale());
    EXPECT_NEAR(3 * pace.scale() * pace.scale(), 1, 0.2);
}

TEST(Pace, goes_on_down_where_a_picture_in_time_lies_between)
{
    Pace pace(1, 0.125, 1);
    const auto see = [&](double cost, int frames) {
        for (int k = 0; k < frames; ++k) pace.took(cost * pace.scale() * pace.scale());
    };
    see(2, 20);
    const double before = pace.scale();
    see(5, 4);  // now as slow as at first, of fewer pixels
    EXPECT_LT(pace.scale(), before);
}

TEST(Pace, is_found_at_once_and_not_by_one_slow_picture)
{
    Pace pace(1, 0.1, 1);
    pace.took(50);
    EXPECT_EQ(pace.scale(), 1) << "it may have waited for something";
    pace.took(1);
    pace.took(9), pace.took(9);
    EXPECT_NEAR(pace.scale(), 1.0 / 3, 1e-12);
    pace.took(1.3), pace.took(1.3);
    EXPECT_NEAR(pace.scale(), 0.25, 1e-12);
}

TEST(TrackingWatch, notices_hands_that_come_too_seldom_to_shape)
{
    // A hand that moves so fast [m/s], in frames of so many a second; whether it was too slow.
    const auto too_slow = [](double rate, double speed, double& entered) {
        HeadsetHands hands{HandsOptions{}};
        TrackingWatch watch;
        bool slow = false;
        for (int i = 0; i <= int(2 * rate); ++i) {
            HandFrame frame;
            frame.time = i / rate;
            Hand& hand = frame.hand[right] = open_hand(right);
            for (auto& joint : hand.joints) joint.p.x += float(speed * frame.time);
            hand.tracked = true, hand.valid.fill(true);
            hands.push(frame);
            watch.frame(frame.time, hands.slow_restarts());
            slow = slow || watch.too_slow();
        }
        entered = watch.rate();
        return slow;
    };
    double rate = 0;
    EXPECT_TRUE(too_slow(3, 0, rate)) << "a hand that is at rest does not touch either";
    EXPECT_NEAR(rate, 3, 0.01);
    EXPECT_FALSE(too_slow(6, 1, rate));
    EXPECT_NEAR(rate, 6, 0.01);
    EXPECT_TRUE(too_slow(6, 3, rate));
    EXPECT_FALSE(too_slow(90, 3, rate));
    EXPECT_FALSE(too_slow(90, 10, rate)) << "whoever tracks it loses it, not the rate";
    TrackingWatch once;
    once.frame(0, 0), once.frame(1, 1);
    EXPECT_FALSE(once.too_slow()) << "a scene was loaded";
    once.frame(2, 2);
    EXPECT_TRUE(once.too_slow());
    once.frame(2.1, 2), once.frame(6, 2);
    EXPECT_FALSE(once.too_slow());
}

// A user's hand is drawn as large as it touches; what it holds has its own size.
TEST(HeadsetHands, are_drawn_as_large_as_the_users_and_touch_so)
{
    constexpr float k = 1.2f;
    HandsOptions options;
    options.zoom = 2, options.held[right] = "ball";
    HandStream stream(options);
    HeadsetHands hands(options);
    HandFrame frame;
    for (const Side side : {left, right}) {
        Hand& hand = frame.hand[side] = open_hand(side);
        hand.tracked = true, hand.valid.fill(true);
        for (auto& joint : hand.joints) joint.p = k * joint.p;
        for (float& r : hand.radius) r *= k;
    }
    for (int i = 0; i < 90; ++i)
        frame.time = i / 90.0, stream.push(frame), hands.push(frame), hands.looks();
    const Motion motion = stream_motion(std::make_shared<HandStream>(stream), options)(0.9, 0.95);
    EXPECT_NEAR(motion.stretch_of(left).across, k, 1e-3);
    EXPECT_EQ(motion.stretch_of(right).across, 1) << "held";

    const std::vector<HandLook> looks = hands.looks();
    ASSERT_EQ(looks.size(), 4u) << "two hands, the ball, its handle";
    for (const Side side : {left, right}) {
        const Mesh wanted =
            hand_skin(options.topology, side).posed(motion.to, options.zoom, {k, k});
        const Mesh& drawn = looks[std::size_t(side)].skins.at(0);
        ASSERT_EQ(drawn.vertices.size(), wanted.vertices.size());
        for (std::size_t v = 0; v < wanted.vertices.size(); v += 11)
            EXPECT_LT(length(drawn.vertices[v] - wanted.vertices[v]), 1e-4f);
    }
    const Rig touching = hand_tools(options).rig;
    float largest = 0, drawn = 0;
    for (const Primitive& p : touching.primitives)
        if (p.tool == 1)
            largest = std::max(largest, touching.spheres[std::size_t(p.sphere[0])].radius);
    for (const DrawPrimitive& p : looks[2].primitives) drawn = std::max(drawn, p.sphere[0].r);
    EXPECT_FLOAT_EQ(drawn, largest);
}

// Haptics: once where contact begins, gently while clay yields, and not for what was felt already.
TEST(HeadsetHands, feel_contact_where_a_tool_touches)
{
    HeadsetHands hands{HandsOptions{}};
    Feel felt[side_count];
    LiveState state;
    state.version = 1;
    state.tools.push_back({right, "", true, 1, {}});
    hands.feel(state, felt);
    EXPECT_EQ(felt[right], Feel::nothing);
    state.version = 2, state.frame.stats.touched = 1, state.frame.stats[Count::yielded] = 9;
    hands.feel(state, felt);
    EXPECT_EQ(felt[right], Feel::contact);
    EXPECT_EQ(felt[left], Feel::nothing);
    hands.feel(state, felt);
    EXPECT_EQ(felt[right], Feel::nothing) << "the same state";
    state.version = 3;
    hands.feel(state, felt);
    EXPECT_EQ(felt[right], Feel::yielding);
}

// Both hands are in the scene; only the one that is at the clay feels it, and a blade feels more.
TEST(HeadsetHands, feel_each_what_it_touches_itself)
{
    HeadsetHands hands{HandsOptions{}};
    Feel felt[side_count];
    LiveState state;
    state.tools.push_back({left, "", true, 1, {}});
    state.tools.push_back({right, "", true, 1, {}});
    state.frame.stats.touched = 1, state.frame.stats[Count::yielded] = 9;
    const auto feel = [&] {
        ++state.version;
        hands.feel(state, felt);
    };
    feel();
    EXPECT_EQ(felt[left], Feel::contact);
    EXPECT_EQ(felt[right], Feel::nothing) << "the other does";
    feel();
    EXPECT_EQ(felt[left], Feel::yielding);
    state.tools[0].held = "knife";
    feel();
    EXPECT_EQ(felt[left], Feel::cutting);
    EXPECT_GT(strength_of(Feel::cutting), strength_of(Feel::yielding));
    state.frame.stats[Count::yielded] = 0;
    feel();
    EXPECT_EQ(felt[left], Feel::nothing) << "it rests";
    state.frame.stats.touched = 3;
    feel();
    EXPECT_EQ(felt[right], Feel::contact) << "its own contact begins";
    state.tools[1].active = false;
    feel();
    EXPECT_EQ(felt[right], Feel::nothing);
}

// A flash where contact begins, which what follows does not cut short, then light for as long as
// clay yields.
TEST(HeadsetHands, show_what_they_feel)
{
    HandCue cue;
    EXPECT_EQ(length(cue.glow(1)), 0);
    cue.show(Feel::contact, 1);
    const float flash = length(cue.glow(1));
    EXPECT_GT(flash, 1);
    cue.show(Feel::yielding, 1.01), cue.show(Feel::nothing, 1.02);
    EXPECT_GT(length(cue.glow(1.02)), 0.9f * flash);
    for (double t = 1.02; t < 2; t += 0.01) cue.show(Feel::yielding, t);
    const float steady = length(cue.glow(2));
    EXPECT_GT(steady, 0.3f);
    EXPECT_LT(steady, 0.6f * flash);
    cue.show(Feel::cutting, 2);
    EXPECT_GT(cue.glow(2).x, 3 * cue.glow(2).y) << "red";
    EXPECT_EQ(length(cue.glow(2 + HandCue::lasting)), 0);
}

TEST(HeadsetHands, glow_while_they_touch)
{
    HeadsetHands hands{HandsOptions{}};
    HandFrame frame;
    frame.hand[right] = open_hand(right);
    for (int k = 0; k < 60; ++k) frame.time = k / 60.0, hands.push(frame);
    LiveState state;
    state.tools.push_back({right, "", true, 1, {}});
    Feel felt[side_count];
    state.version = 1;
    hands.feel(state, felt);
    ASSERT_FALSE(hands.looks().empty());
    EXPECT_EQ(length(hands.looks().front().glow), 0);
    state.version = 2, state.frame.stats.touched = 1;
    hands.feel(state, felt);
    EXPECT_GT(length(hands.looks().front().glow), 1);
}

TEST(HeadsetHands, draw_nothing_before_a_hand_came_and_faintly_before_it_touches)
{
    HeadsetHands hands{HandsOptions{}};
    EXPECT_TRUE(hands.looks().empty());
    HandFrame frame;
    frame.hand[right] = open_hand(right);
    frame.hand[right].tracked = true;
    frame.hand[right].valid.fill(true);
    for (int k = 0; k < 200; ++k) {
        frame.time = k / 90.0;
        hands.push(frame);
        const std::vector<HandLook> looks = hands.looks();
        if (k == 0) continue;
        ASSERT_EQ(looks.size(), 1u) << "the left hand was never seen";
        EXPECT_FALSE(looks[0].skins.empty());
        EXPECT_LE(looks[0].opacity, frame.time < 0.15 ? HandFade::faint : 1.0f);
        EXPECT_GE(looks[0].opacity, frame.time > 1 ? 1.0f : 0.0f);
    }
}

}  // namespace
}  // namespace knead
