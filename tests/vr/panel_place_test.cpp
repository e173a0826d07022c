// Where the panels of the headset stand, measured with the recorded hands of scenes/.
#include "host/vr/panel_place.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <numbers>
#include <random>

#include "host/hands/gesture.h"
#include "host/hands/recording.h"
#include "host/scene/seed.h"

namespace knead {
namespace {

using V = Vec3<float>;

std::vector<std::string> recordings()
{
    std::vector<std::string> paths;
    for (const auto& entry : std::filesystem::directory_iterator("scenes"))
        if (entry.path().extension() == ".hands") paths.push_back(entry.path().string());
    return paths;
}

// Calls visit(joint's centre, radius) for all hands of a recording; and mirrored, for users whose
// other hand leads.
template <class Visit>
void for_each_joint(const Recording& recording, const Visit& visit)
{
    for (const HandFrame& frame : recording.frames)
        for (const Hand& hand : frame.hand) {
            if (!hand.tracked) continue;
            for (int j = 0; j < joint_count; ++j) {
                if (!hand.valid[j]) continue;
                visit(hand.joints[j].p, hand.radius[j]);
                visit(mirrored(hand.joints[j]).p, hand.radius[j]);
            }
        }
}

float clearance(const Joint<float>& pose, const Recording& recording)
{
    float least = 1e30f;
    for_each_joint(recording, [&](V at, float radius) {
        least = std::min(least, distance_to_panel(pose, PanelSize{}, at) - radius);
    });
    return least;
}

const Box3<double> nothing = empty_box<double>();

TEST(MainPanel, stands_where_no_shaping_hand_passes)
{
    const std::vector<std::string> paths = recordings();
    ASSERT_GE(paths.size(), 9u);
    for (const std::string& path : paths) {
        const Recording recording = read_recording(path);
        for (const Side side : {left, right}) {
            const PanelPlace place = main_panel_pose({}, side, nothing, {});
            EXPECT_GE(clearance(place.pose, recording), panel_clearance) << path;
        }
    }
    // Trembling hands, and deeper presses.
    for (const Gesture& gesture : gestures()) {
        GestureOptions options;
        options.jitter = 0.001, options.depth = std::min(0.9, 1.3 * gesture.depth);
        const Recording recording = generate(gesture.name, options);
        const PanelPlace place = main_panel_pose({}, right, nothing, {});
        EXPECT_GE(clearance(place.pose, recording), panel_clearance) << gesture.name;
    }
}

TEST(MainPanel, is_within_reach_and_faces_the_head)
{
    const Workplace usual;
    const V head = -cast<float>(usual.at);
    const PanelSize size;
    for (const Side side : {left, right}) {
        const PanelPlace place = main_panel_pose(usual, side, nothing, {});
        EXPECT_TRUE(place.reached && place.clear_of_clay);
        EXPECT_EQ(place.pose.p.x < 0, side == left);
        const V to_head = head - place.pose.p;
        EXPECT_FLOAT_EQ(place.distance, length(to_head));
        EXPECT_GT(place.distance, 0.4f);
        EXPECT_LT(place.distance, 0.65f);
        EXPECT_GT(dot(rotate(place.pose.q, V{0, 0, 1}), to_head), 0.9999f * length(to_head));
        EXPECT_GT(rotate(place.pose.q, V{0, 1, 0}).y, 0.7f) << "it is read upright";
        EXPECT_NEAR(rotate(place.pose.q, V{1, 0, 0}).y, 0, 1e-6f) << "and level";
        const V shoulder = head + V{side == left ? -shoulder_from_eyes.x : shoulder_from_eyes.x,
                                    shoulder_from_eyes.y, shoulder_from_eyes.z};
        for (const float x : {-0.2f, 0.2f})
            for (const float y : {-0.2f, 0.2f}) {
                const V corner = place.pose.p + rotate(place.pose.q, V{x, y, 0});
                EXPECT_LE(length(corner - shoulder), panel_reach);
            }
        // The smallest letters: in the corners, pointing outwards.
        const float h = panel_letter_height(place.distance, size);
        const auto seen = [&](V from, V to) {
            const V a = head - (place.pose.p + rotate(place.pose.q, from));
            const V b = head - (place.pose.p + rotate(place.pose.q, to));
            return std::atan2(length(cross(a, b)), dot(a, b)) * 180 / std::numbers::pi_v<float>;
        };
        const float s = std::sqrt(0.5f) * h;
        EXPECT_NEAR(seen({0.2f, 0.2f, 0}, {0.2f - s, 0.2f - s, 0}), 1, 0.02f);
        EXPECT_GE(seen({0.2f, 0.2f, 0}, {0.2f, 0.2f - h, 0}), 1);
        EXPECT_GE(seen({0, 0, 0}, {0, h, 0}), 1);
    }
}

// Where the head is relative to the workplace counts, and where the headset's axes point does not.
TEST(MainPanel, follows_the_workplace)
{
    Workplace turned;
    turned.turn = 0.8;
    turned.at = rotate(turn_about(Vec3<double>{0, 1, 0}, turned.turn), Workplace{}.at);
    const PanelPlace a = main_panel_pose({}, left, nothing, {}),
                     b = main_panel_pose(turned, left, nothing, {});
    EXPECT_NEAR(length(a.pose.p - b.pose.p), 0, 1e-6f);
    EXPECT_NEAR(a.distance, b.distance, 1e-6f);
    for (const Vec3<double> at : {Vec3<double>{0, -0.35, -0.9}, Vec3<double>{0, -0.5, -0.4},
                                  Vec3<double>{0.1, -0.2, -0.5}}) {
        Workplace other;
        other.at = at;
        for (const Side side : {left, right})
            EXPECT_TRUE(main_panel_pose(other, side, nothing, {}).reached) << at.z;
    }
    Workplace in_head;
    in_head.at = {0, 0, 0};
    for (const Side side : {left, right})
        EXPECT_TRUE(std::isfinite(main_panel_pose(in_head, side, nothing, {}).distance));
}

// Whether a box and a panel have a point in common, by points on the panel.
bool touches(const Joint<float>& pose, const Box3<double>& box)
{
    for (int i = 0; i <= 40; ++i)
        for (int j = 0; j <= 40; ++j) {
            const V at{-0.2f + 0.01f * float(i), -0.2f + 0.01f * float(j), 0};
            if (contains(box, cast<double>(pose.p + rotate(pose.q, at)))) return true;
        }
    return false;
}

TEST(MainPanel, does_not_enter_zoomed_clay_where_it_can_be_avoided)
{
    const Box3<double> clay{{0.3, 0.1, 0.3}, {0.7, 0.5, 0.7}};
    int moved = 0, impossible = 0;
    for (double zoom = 4; zoom > 0.05; zoom *= 0.9) {
        HandsOptions hands;
        hands.zoom = zoom, hands.at = {0.5, 0.3, 0.5};
        const Box3<double> seen{(1 / zoom) * (clay.low - hands.at),
                                (1 / zoom) * (clay.high - hands.at)};
        for (const Side side : {left, right}) {
            const PanelPlace place = main_panel_pose({}, side, clay, hands);
            const PanelPlace usual = main_panel_pose({}, side, nothing, hands);
            EXPECT_EQ(place.clear_of_clay, !touches(place.pose, seen)) << zoom;
            if (!touches(usual.pose, expanded(seen, 0.02))) {
                EXPECT_EQ(place.pose.p.x, usual.pose.p.x) << zoom;
            }
            moved += place.clear_of_clay && place.pose.p.x != usual.pose.p.x;
            impossible += !place.clear_of_clay;
            EXPECT_TRUE(place.reached);
        }
    }
    EXPECT_GE(moved, 4);
    EXPECT_GE(impossible, 4) << "the clay is all around";
    std::mt19937 random(3);
    std::uniform_real_distribution<double> share(-0.6, 0.6);
    for (int k = 0; k < 200; ++k) {
        Box3<double> box = empty_box<double>();
        for (int i = 0; i < 2; ++i)
            grow(box, Vec3<double>{share(random), share(random), share(random)});
        const PanelPlace place = main_panel_pose({}, k % 2 ? left : right, box, {});
        EXPECT_TRUE(place.reached);
        EXPECT_FALSE(place.clear_of_clay && touches(place.pose, box));
    }
}

Hand at_rest(V palm_at, Quat<float> turn)
{
    Hand hand = open_hand(left);
    const Joint<float> was = hand.joints[palm];
    const Quat<float> by = turn * conjugate(was.q);
    for (Joint<float>& joint : hand.joints)
        joint = {by * joint.q, palm_at + rotate(by, joint.p - was.p)};
    hand.tracked = true;
    hand.valid.fill(true);
    return hand;
}

TEST(PalmStrip, lies_above_the_skin_of_the_palm_with_its_top_towards_the_fingers)
{
    const Hand hand = at_rest({0.1f, 0.2f, 0.3f}, unit(Quat<float>{0.9f, 0.2f, -0.3f, 0.1f}));
    const std::optional<Joint<float>> pose = palm_pose(hand, 0.01f);
    ASSERT_TRUE(pose);
    const Joint<float>& joint = hand.joints[palm];
    const V outwards = rotate(joint.q, V{0, -1, 0});
    EXPECT_NEAR(length(pose->p - joint.p), hand.radius[palm] + 0.01f, 1e-6f);
    EXPECT_NEAR(dot(pose->p - joint.p, outwards), hand.radius[palm] + 0.01f, 1e-6f);
    EXPECT_NEAR(length(rotate(pose->q, V{0, 0, 1}) - outwards), 0, 1e-5f);
    const V fingers = hand.joints[middle_tip].p - hand.joints[wrist].p;
    EXPECT_GT(dot(rotate(pose->q, V{0, 1, 0}), fingers), 0.9f * length(fingers));
    EXPECT_GT(dot(rotate(pose->q, V{0, 0, 1}), hand.joints[middle_tip].p - pose->p), -0.05f);
    Hand lost = hand;
    lost.tracked = false;
    EXPECT_FALSE(palm_pose(lost));
    lost = hand, lost.valid[palm] = false;
    EXPECT_FALSE(palm_pose(lost));
    lost = hand, lost.joints[palm].q = {0, 0, 0, 0};
    EXPECT_FALSE(palm_pose(lost));
    lost = hand, lost.joints[palm].p.x = std::nanf("");
    EXPECT_FALSE(palm_pose(lost));
}

// A palm whose normal has this angle to the head, which is above it [deg].
Hand turned_palm(float angle)
{
    const float radians = angle * std::numbers::pi_v<float> / 180;
    return at_rest({0, 0, 0}, turn_about(V{0, 0, 1}, std::numbers::pi_v<float> + radians));
}
const V above{0, 1e3f, 0};

TEST(PalmStrip, is_shown_while_the_palm_is_turned_to_the_head)
{
    PalmStrip strip;
    double time = 0;
    const auto shown = [&](float angle) {
        return strip.frame(time += 0.01, turned_palm(angle), above, false, false);
    };
    EXPECT_FALSE(shown(180));
    EXPECT_FALSE(shown(50));
    EXPECT_FALSE(shown(-46));
    EXPECT_TRUE(shown(44));
    EXPECT_TRUE(shown(-59));
    EXPECT_FALSE(shown(61));
    EXPECT_FALSE(shown(50)) << "it must turn back";
    EXPECT_TRUE(shown(0));
    Hand lost = turned_palm(0);
    lost.tracked = false;
    EXPECT_FALSE(strip.frame(time += 0.01, lost, above, false, false));
    EXPECT_FALSE(shown(50)) << "it was hidden";
    EXPECT_TRUE(shown(10));
    EXPECT_FALSE(strip.frame(time, turned_palm(0), {std::nanf(""), 0, 0}, false, false));
}

TEST(PalmStrip, is_not_shown_on_a_hand_that_shapes_or_holds)
{
    PalmStrip strip;
    const Hand hand = turned_palm(0);
    EXPECT_TRUE(strip.frame(1, hand, above, false, false));
    EXPECT_FALSE(strip.frame(1.1, hand, above, true, false));
    EXPECT_FALSE(strip.frame(1.2, hand, above, false, false));
    EXPECT_FALSE(strip.frame(1.79, hand, above, false, false));
    EXPECT_TRUE(strip.frame(1.81, hand, above, false, false));
    EXPECT_FALSE(strip.frame(2, hand, above, false, true)) << "a tool";
    EXPECT_TRUE(strip.frame(2.01, hand, above, false, false));
}

// Contact is taken to be where a joint is within a centimetre of the clay's first bounds. Shaping
// hands do not show the strip at all: their palms face the clay.
TEST(PalmStrip, is_never_shown_on_recorded_hands_that_shape)
{
    int contacts = 0;  // none of hands that hold a tool
    for (const std::string& path : recordings()) {
        const std::string scene_path = path.substr(0, path.size() - 6) + ".json";
        const Scene scene = read_scene(scene_path);
        Box3<double> clay = empty_box<double>();
        for (const Object& object : scene.objects) grow(clay, box_of(object));
        const double zoom = scene.hands.zoom;
        const Box3<double> box = expanded(Box3<double>{(1 / zoom) * (clay.low - scene.hands.at),
                                                       (1 / zoom) * (clay.high - scene.hands.at)},
                                          0.01);
        const V head = -cast<float>(Workplace{}.at);
        const Recording recording = read_recording(path);
        PalmStrip strip[side_count], blind[side_count];
        for (const HandFrame& frame : recording.frames)
            for (const Side side : {left, right}) {
                const Hand& hand = frame.hand[side];
                bool contact = false;
                for (int j = 0; j < joint_count; ++j)
                    contact = contact || (hand.tracked && hand.valid[j] &&
                                          contains(box, cast<double>(hand.joints[j].p)));
                contacts += contact;
                const bool shown = strip[side].frame(frame.time, hand, head, contact, false);
                EXPECT_FALSE(shown && contact) << path << " " << frame.time;
                EXPECT_FALSE(blind[side].frame(frame.time, hand, head, false, false))
                    << path << " " << frame.time;
            }
    }
    EXPECT_GT(contacts, 300);
}

// Whatever a hand does: the strip is shown only under its conditions, and faces the head.
TEST(PalmStrip, of_random_hands_is_shown_under_its_conditions_alone)
{
    std::mt19937 random(11);
    std::uniform_real_distribution<float> share(-1, 1);
    PalmStrip strip;
    double time = 0, touched = -1e30;
    int count = 0;
    for (int k = 0; k < 20000; ++k) {
        time += 0.05 + 0.05 * share(random);
        const Quat<float> turn{share(random), share(random), share(random), share(random)};
        Hand hand = at_rest({share(random), share(random), share(random)},
                            unit(turn * Quat<float>{1, 1e-3f, 0, 0}));
        hand.tracked = share(random) > -0.9f;
        const V head{share(random), share(random), share(random)};
        const bool contact = share(random) > 0.95f, busy = share(random) > 0.9f;
        if (contact) touched = time;
        if (!strip.frame(time, hand, head, contact, busy)) continue;
        ++count;
        EXPECT_TRUE(hand.tracked && !contact && !busy && time - touched >= PalmStrip::rest);
        const Joint<float> pose = palm_pose(hand, 0.01f).value();
        const V to_head = head - pose.p;
        EXPECT_GT(dot(rotate(pose.q, V{0, 0, 1}), to_head), 0.499f * length(to_head));
    }
    EXPECT_GT(count, 100);
}

}  // namespace
}  // namespace knead
