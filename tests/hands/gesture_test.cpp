// Made gestures move as hands do, start clear of the ball and go exactly as deep as asked.
#include "host/hands/gesture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "host/hands/posture.h"
#include "host/hands/recording.h"

namespace knead {
namespace {

using Vec = Vec3<double>;
using Joints = std::array<Joint<double>, 2 * joint_count>;

Joints joints_of(const HandFrame& frame)
{
    Joints joints;
    for (int s = 0; s < 2; ++s)
        for (int j = 0; j < joint_count; ++j) {
            const Joint<float>& joint = frame.hand[s].joints[j];
            joints[s * joint_count + j] = {cast<double>(joint.q), cast<double>(joint.p)};
        }
    return joints;
}

Rig held_rig(const Gesture& gesture, Side side, Topology topology)
{
    const std::string& tool = gesture.held[side];
    return tool.empty() ? hand_rig(topology, side) : tool_rig(tool, side);
}

// The gap of each frame.
std::vector<double> gaps(const Recording& r, const Gesture& gesture, const GestureOptions& options,
                         Side side)
{
    const Rig rig = held_rig(gesture, side, options.topology);
    std::vector<double> list;
    for (const HandFrame& frame : r.frames)
        list.push_back(gap(rig, joints_of(frame).data(), options.centre, options.radius));
    return list;
}

double min_of(const std::vector<double>& list) { return *std::ranges::min_element(list); }

const Gesture& gesture_named(const std::string& name)
{
    return *std::ranges::find(gestures(), name, &Gesture::name);
}

double peak_speed(const Recording& r, Side side, int joint, double from, double to)
{
    double peak = 0;
    for (std::size_t i = 1; i < r.frames.size(); ++i) {
        const HandFrame &a = r.frames[i - 1], &b = r.frames[i];
        if (a.time < from || b.time > to) continue;
        const auto way = b.hand[side].joints[joint].p - a.hand[side].joints[joint].p;
        peak = std::max(peak, double(length(way)) / (b.time - a.time));
    }
    return peak;
}

TEST(Gesture, TheGapAgreesWithBallsSpreadOverThePrimitives)
{
    const GestureOptions options;
    const Recording r = generate("squeeze", options);
    for (const Topology topology : {Topology::h25, Topology::h47}) {
        const Rig rig = hand_rig(topology, left);
        for (std::size_t i = 0; i < r.frames.size(); i += 30) {
            const Joints joints = joints_of(r.frames[i]);
            double nearest = 1e30;
            for (const Primitive& p : rig.primitives) {
                Vec c[3];
                double radius[3];
                for (int k = 0; k < 3; ++k) {
                    const Binding<float>& b = rig.spheres[p.sphere[k]];
                    c[k] = {};
                    radius[k] = b.radius;
                    for (int n = 0; n < 4; ++n) {
                        const Joint<double>& j = joints[b.joint[n]];
                        const Vec at = j.p + rotate(j.q, cast<double>(b.offset[n]));
                        c[k] = c[k] + double(b.weight[n]) * at;
                    }
                }
                const int steps = 40;
                for (int u = 0; u <= steps; ++u)
                    for (int v = 0; u + v <= steps; ++v) {
                        const double l1 = double(u) / steps, l2 = double(v) / steps;
                        const double l0 = 1 - l1 - l2;
                        const Vec at = l0 * c[0] + l1 * c[1] + l2 * c[2];
                        const double r_at = l0 * radius[0] + l1 * radius[1] + l2 * radius[2];
                        nearest = std::min(nearest, length(at) - r_at - options.radius);
                    }
            }
            EXPECT_NEAR(gap(rig, joints.data(), {}, options.radius), nearest, 1e-4);
        }
    }
}

TEST(Gesture, EveryHandAndToolStartsTenCentimetresFromTheBall)
{
    for (const Gesture& gesture : gestures()) {
        const GestureOptions options;
        const Recording r = generate(gesture.name, options);
        for (const Side side : {left, right}) {
            EXPECT_NEAR(gaps(r, gesture, options, side).front(), 0.1, 1e-4) << gesture.name;
            if (!gesture.held[side].empty()) {
                const Gesture bare{gesture.name, {}, 0, 0};
                EXPECT_GT(gaps(r, bare, options, side).front(), 0) << gesture.name;
            }
        }
    }
}

TEST(Gesture, EveryGestureGoesAsDeepAsItsOwnDepth)
{
    for (const Gesture& gesture : gestures()) {
        const GestureOptions options{.rate = 120};
        const Recording r = generate(gesture.name, options);
        double deepest = 0;
        for (const Side side : {left, right})
            deepest = std::min(deepest, min_of(gaps(r, gesture, options, side)));
        EXPECT_NEAR(-deepest / options.radius, gesture.depth, 0.01) << gesture.name;
    }
}

TEST(Gesture, ASqueezeGoesAsDeepAsAskedWhateverTheBallAndTheHand)
{
    for (const double radius : {0.05, 0.1, 0.2})
        for (const double depth : {0.18, 0.25})
            for (const Topology topology : {Topology::h25, Topology::h47}) {
                const GestureOptions options{.depth = depth,
                                             .centre = {0.3, 1.1, -0.4},
                                             .radius = radius,
                                             .topology = topology};
                const Recording r = generate("squeeze", options);
                for (const Side side : {left, right}) {
                    const auto list = gaps(r, gesture_named("squeeze"), options, side);
                    EXPECT_NEAR(-min_of(list) / radius, depth, 0.005);
                    EXPECT_GT(list.front(), 0.09);
                    EXPECT_GT(list.back(), 0.09);
                }
            }
}

TEST(Gesture, SqueezingPalmsFaceEachOtherAndAllFingersLieOnTheBall)
{
    const GestureOptions options;
    const Recording r = generate("squeeze", options);
    const auto pressed =
        std::ranges::find_if(r.frames, [](const HandFrame& f) { return f.time > 1.5 + 0.038; });
    ASSERT_NE(pressed, r.frames.end());
    for (const Side side : {left, right}) {
        const Hand& hand = pressed->hand[side];
        const auto out = rotate(hand.joints[palm].q, Vec3<float>{0, -1, 0});
        EXPECT_GT(side == right ? -out.x : out.x, 0.95f);
        EXPECT_EQ(hand.joints[palm].p.x > 0, side == right);
        for (const int tip : {index_tip, middle_tip, ring_tip, little_tip})
            EXPECT_LT(length(hand.joints[tip].p), 0.1f + 0.015f) << joint_names[tip];
        EXPECT_LT(length(hand.joints[palm].p), 0.1f + 0.02f);
    }
}

TEST(Gesture, HandsMoveAtHumanSpeeds)
{
    for (const Gesture& gesture : gestures()) {
        const Recording r = generate(gesture.name);
        double fastest = 0;
        for (const Side side : {left, right})
            fastest = std::max(fastest, peak_speed(r, side, palm, 0, 100));
        EXPECT_GT(fastest, 0.3) << gesture.name;
        EXPECT_LT(fastest, 0.7) << gesture.name;
    }
    const Recording r = generate("squeeze");
    EXPECT_LT(peak_speed(r, right, palm, 0.55, 1.7), 0.1);  // while it presses
}

TEST(Gesture, PinchingTipsMeetInsideTheBall)
{
    const GestureOptions options;
    const Recording r = generate("pinch", options);
    const Hand open = open_hand(right);
    const double touching = open.radius[thumb_tip] + open.radius[index_tip];
    double nearest = 1, depth = -1;
    for (const HandFrame& frame : r.frames) {
        const auto& joints = frame.hand[right].joints;
        const double apart = length(joints[thumb_tip].p - joints[index_tip].p);
        nearest = std::min(nearest, apart);
        if (apart < touching + 0.003)
            depth = std::max(depth, options.radius - double(length(joints[index_tip].p)));
    }
    EXPECT_NEAR(nearest, touching, 0.002);
    EXPECT_GT(depth, 0.005);
}

// Every place of the ball's middle plane is passed by the blade, down to the board and no deeper.
TEST(Gesture, TheKnifeSweepsTheWholeOfASmallBall)
{
    const GestureOptions options{.rate = 120, .radius = 0.05};
    const Recording r = generate("cut", options);
    const Rig rig = tool_rig("knife", right);
    constexpr int count = 41;  // places along either axis
    std::vector<char> passed(count * count, 0);
    const auto place = [&](int i) { return options.radius * (2.0 * i / (count - 1) - 1); };
    double lowest = 1;
    for (const HandFrame& frame : r.frames) {
        if (frame.time > 1.65 + options.latency) break;  // then it leaves the plane
        const Joints joints = joints_of(frame);
        std::vector<Sphere<double>> s;
        for (const Binding<float>& b : rig.spheres) {
            const Joint<double>& j = joints[b.joint[0]];
            s.push_back({j.p + rotate(j.q, cast<double>(b.offset[0])), {}, {}, b.radius, 0});
            lowest = std::min(lowest, s.back().c.y);
        }
        for (const Primitive& p : rig.primitives) {
            const auto blade = shape(3, s[p.sphere[0]], s[p.sphere[1]], s[p.sphere[2]]);
            for (int i = 0; i < count * count; ++i) {
                const Vec at{0, place(i / count), place(i % count)};
                if (length(at) > options.radius || closest_point(blade, at).phi < 0.002)
                    passed[i] = 1;
            }
        }
    }
    EXPECT_NEAR(lowest, -options.radius, 0.002);
    EXPECT_EQ(std::ranges::count(passed, 0), 0);
}

TEST(Gesture, BonesKeepTheirLengths)
{
    const int parents[][2] = {{wrist, palm},
                              {wrist, index_metacarpal},
                              {index_metacarpal, index_proximal},
                              {index_proximal, index_intermediate},
                              {index_distal, index_tip},
                              {thumb_metacarpal, thumb_proximal},
                              {thumb_distal, thumb_tip},
                              {little_intermediate, little_distal}};
    for (const Gesture& gesture : gestures()) {
        const Recording r = generate(gesture.name, {.jitter = 2e-3});
        for (const HandFrame& frame : r.frames)
            for (const Side side : {left, right}) {
                const Hand open = open_hand(side);
                for (const auto& [a, b] : parents) {
                    const auto& joints = frame.hand[side].joints;
                    ASSERT_NEAR(length(joints[a].p - joints[b].p),
                                length(open.joints[a].p - open.joints[b].p), 1e-6f);
                }
            }
    }
}

TEST(Gesture, JitterIsTheRmsDisplacementOfTheJoints)
{
    const double jitter = 1.5e-3;
    GestureOptions options{.rate = 72, .seconds = 10};
    const Recording still = generate("knead", options);
    options.jitter = jitter;
    const Recording shaken = generate("knead", options);
    double sum = 0;
    for (std::size_t i = 0; i < still.frames.size(); ++i)
        for (const Side side : {left, right})
            for (int j = 0; j < joint_count; ++j) {
                const auto d = shaken.frames[i].hand[side].joints[j].p -
                               still.frames[i].hand[side].joints[j].p;
                sum += dot(d, d);
            }
    const double rms = std::sqrt(sum / double(still.frames.size() * 2 * joint_count));
    EXPECT_NEAR(rms, jitter, 0.15 * jitter);
}

TEST(Gesture, EqualRulesGiveEqualRecordingsAndSeedsDiffer)
{
    const GestureOptions options{.jitter = 1e-3, .dropouts = 0.02, .seed = 5};
    GestureOptions other = options;
    other.seed = 6;
    const std::string first = to_binary(generate("roll", options));
    EXPECT_EQ(first, to_binary(generate("roll", options)));
    EXPECT_NE(first, to_binary(generate("roll", other)));
}

// The random numbers use nothing but the standard's engine and exact arithmetic.
TEST(Gesture, TimeStampsAreTheSameOnEveryPlatform)
{
    const Recording r = generate("squeeze", {.seed = 1});
    EXPECT_DOUBLE_EQ(r.frames[0].time, 0.038);
    EXPECT_DOUBLE_EQ(r.frames[1].time, 0.055485440860671975);
    EXPECT_DOUBLE_EQ(r.frames[100].time, 1.7046600659423667);
}

TEST(Gesture, TimeStampsAreLateAndALittleUneven)
{
    const GestureOptions options{.rate = 30, .latency = 0.05};
    const Recording r = generate("squeeze", options);
    EXPECT_EQ(r.frames.size(), 79u);  // 2.6 s
    EXPECT_DOUBLE_EQ(r.latency, 0.05);
    std::set<double> spacings;
    for (std::size_t i = 0; i < r.frames.size(); ++i) {
        EXPECT_NEAR(r.frames[i].time, 0.05 + double(i) / 30, 0.1 / 30);
        if (i > 0) spacings.insert(r.frames[i].time - r.frames[i - 1].time);
    }
    EXPECT_GT(spacings.size(), 60u);
}

TEST(Gesture, LostHandsHoldStillForThreeToTenFrames)
{
    const Recording r = generate("squeeze", {.dropouts = 0.02, .seconds = 60});
    int spells = 0;
    for (const Side side : {left, right}) {
        int spell = 0;
        for (std::size_t i = 0; i < r.frames.size(); ++i) {
            const Hand& hand = r.frames[i].hand[side];
            if (!hand.tracked) {
                ++spell;
                EXPECT_FALSE(hand.valid[palm]);
                EXPECT_EQ(hand.joints[palm].p.x, r.frames[i - 1].hand[side].joints[palm].p.x);
            } else if (spell > 0) {
                EXPECT_GE(spell, 3);
                EXPECT_LE(spell, 10);
                ++spells;
                spell = 0;
            }
        }
    }
    EXPECT_GT(spells, 80);  // of about 2 * 3600 * 0.02 / (1 + 0.02 * 6.5)
    EXPECT_LT(spells, 170);
}

TEST(Gesture, EveryGesturePassesTheCheckOfRecordings)
{
    for (const Gesture& gesture : gestures())
        EXPECT_NO_THROW(check(generate(gesture.name, {.jitter = 2e-3, .dropouts = 0.05})));
}

// docs/reference/recordings.md says with which rules they were made.
TEST(Gesture, CommittedRecordingsAreSmallAndComeFromTheirRules)
{
    std::uintmax_t total = 0;
    for (const Gesture& gesture : gestures()) {
        const std::string path = std::string("scenes/") + gesture.name + ".hands";
        const std::uintmax_t size = std::filesystem::file_size(path);
        EXPECT_LT(size, 400000u) << path;
        total += size;
        GestureOptions options{.rate = 30, .jitter = 1.5e-3};
        if (gesture.name == "squeeze") options.rate = 60;
        if (gesture.name == "knead") options.dropouts = 0.01;
        if (gesture.name == "cut") options.radius = 0.05;
        const Recording stored = read_recording(path), made = generate(gesture.name, options);
        ASSERT_EQ(stored.frames.size(), made.frames.size()) << path;
        for (std::size_t i = 0; i < made.frames.size(); ++i) {
            ASSERT_DOUBLE_EQ(stored.frames[i].time, made.frames[i].time);
            for (const Side side : {left, right}) {
                const Hand &a = stored.frames[i].hand[side], &b = made.frames[i].hand[side];
                ASSERT_EQ(a.tracked, b.tracked);
                for (int j = 0; j < joint_count; ++j)
                    ASSERT_LT(length(a.joints[j].p - b.joints[j].p), 1e-5f) << path << i;
            }
        }
    }
    EXPECT_LT(total, 3000000u);
}

TEST(Gesture, UnknownNamesAndRulesOutOfRangeAreRefused)
{
    try {
        generate("sqeeze");
        FAIL();
    } catch (const InputError& error) {
        EXPECT_NE(std::string(error.what()).find("squeeze, imprint"), std::string::npos);
    }
    EXPECT_THROW(generate("squeeze", {.rate = 0}), InputError);
    EXPECT_THROW(generate("squeeze", {.jitter = -1}), InputError);
    EXPECT_THROW(generate("squeeze", {.latency = std::nan("")}), InputError);
    EXPECT_THROW(generate("squeeze", {.seconds = 1e9}), InputError);
    EXPECT_THROW(generate("squeeze", {.depth = 1.5}), InputError);
    EXPECT_THROW(generate("squeeze", {.centre = {1e9, 0, 0}}), InputError);
    EXPECT_THROW(generate("squeeze", {.radius = 0}), InputError);
}

}  // namespace
}  // namespace knead
