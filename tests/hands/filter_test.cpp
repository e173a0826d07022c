// Filters calm a hand without delaying it, never let a leaping hand touch, and recordings are
// sampled where they stand in time and space.
#include "host/hands/filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host/hands/gesture.h"

namespace knead {
namespace {

constexpr Filter all_filters[] = {Filter::none, Filter::average, Filter::adaptive};

Hand hand_at(Vec3<float> p)
{
    Hand hand = open_hand(right);
    for (auto& joint : hand.joints) joint.p = joint.p + p;
    return hand;
}

void expect_near(Vec3<float> a, Vec3<float> b, float tolerance)
{
    EXPECT_LT(length(a - b), tolerance);
}

TEST(Filter, NoneChangesNothing)
{
    HandFilter filter(Filter::none);
    for (int i = 0; i < 20; ++i) {
        const Hand hand = hand_at({0.01f * float(i), 0, 0});
        const Hand out = filter.filter(hand, i / 60.0);
        for (int j = 0; j < joint_count; ++j) expect_near(out.joints[j].p, hand.joints[j].p, 1e-9f);
    }
}

TEST(Filter, AStillHandStaysExactlyWhereItIs)
{
    for (const Filter kind : all_filters) {
        HandFilter filter(kind);
        const Hand hand = hand_at({0.2f, 1.1f, -0.3f});
        Hand out;
        for (int i = 0; i < 100; ++i) out = filter.filter(hand, i / 72.0);
        for (int j = 0; j < joint_count; ++j) {
            expect_near(out.joints[j].p, hand.joints[j].p, 1e-6f);
            const Quat<float> turn = out.joints[j].q * conjugate(unit(hand.joints[j].q));
            EXPECT_NEAR(std::abs(turn.w), 1, 1e-6f);
        }
    }
}

// Frames of a tenth and a twentieth of a second: weights 0.1 and 0.05, and the older frame only
// by the 0.05 s that still lie in the window.
TEST(Filter, AverageWeighsFramesByTheirDuration)
{
    HandFilter filter(Filter::average);
    filter.filter(hand_at({0, 0, 0}), 0.0);
    filter.filter(hand_at({0.01f, 0, 0}), 0.1);
    filter.filter(hand_at({0.02f, 0, 0}), 0.2);
    const Hand out = filter.filter(hand_at({0.04f, 0, 0}), 0.25);
    const float expected = (0.05f * 0.01f + 0.1f * 0.02f + 0.05f * 0.04f) / 0.2f;
    EXPECT_NEAR(out.joints[wrist].p.x - open_hand(right).joints[wrist].p.x, expected, 1e-6f);
}

// Mean age of the frames in a window of 0.2 s: half of it less half a frame.
TEST(Filter, AverageLagsByHalfItsWindow)
{
    for (const double rate : {30.0, 60.0, 90.0}) {
        const Response r = response(Filter::average, rate);
        EXPECT_NEAR(r.ramp, 0.1 - 0.5 / rate, 2e-3) << rate;
        EXPECT_NEAR(r.sine, 0.1 - 0.5 / rate, 2e-3) << rate;
        EXPECT_NEAR(r.jitter, 1 / std::sqrt(0.2 * rate), 0.04) << rate;
    }
}

TEST(Filter, AdaptiveIsTwentyTimesQuickerThanTheAverageAndNearlyAsCalm)
{
    for (const double rate : {30.0, 60.0, 72.0, 90.0}) {
        const Response average = response(Filter::average, rate);
        const Response adaptive = response(Filter::adaptive, rate);
        EXPECT_LT(adaptive.ramp, 0.05 * average.ramp) << rate;
        EXPECT_LT(adaptive.sine, 0.06 * average.sine) << rate;
        EXPECT_LT(adaptive.jitter, 1.6 * average.jitter) << rate;
        EXPECT_DOUBLE_EQ(lag(Filter::adaptive, rate), adaptive.ramp);
    }
    EXPECT_NEAR(response(Filter::none, 60).ramp, 0, 1e-6);
    EXPECT_NEAR(response(Filter::none, 60).jitter, 1, 0.05);
}

// Against the same gesture tracked without noise.
TEST(Filter, AdaptiveStaysAsNearTheTrueHandAsTheTrackerAndTheAverageDoesNot)
{
    for (const double rate : {30.0, 60.0, 72.0})
        for (const char* name : {"squeeze", "knead", "pinch"}) {
            const Recording truth = generate(name, {.rate = rate});
            const Recording noisy = generate(name, {.rate = rate, .jitter = 1.5e-3});
            double error[3] = {};
            for (const Filter kind : all_filters) {
                HandFilter filter(kind);
                for (std::size_t i = 0; i < truth.frames.size(); ++i) {
                    const Hand& hand = noisy.frames[i].hand[right];
                    const Hand out = filter.filter(hand, noisy.frames[i].time);
                    for (int j = 0; j < joint_count; ++j) {
                        const auto d = out.joints[j].p - truth.frames[i].hand[right].joints[j].p;
                        error[int(kind)] += dot(d, d) / double(joint_count * truth.frames.size());
                    }
                }
            }
            for (double& e : error) e = 1e3 * std::sqrt(e);
            EXPECT_LT(error[int(Filter::adaptive)], 0.2 * error[int(Filter::average)])
                << name << " " << rate << ": " << error[0] << " " << error[1] << " " << error[2];
            EXPECT_LT(error[int(Filter::adaptive)], 1.2 * error[int(Filter::none)])
                << name << " " << rate << ": " << error[0] << " " << error[1] << " " << error[2];
        }
}

TEST(Filter, TheSignOfAQuaternionDoesNotMatter)
{
    for (const Filter kind : all_filters) {
        HandFilter filter(kind);
        const Hand hand = hand_at({});
        for (int i = 0; i < 40; ++i) {
            Hand given = hand;
            if (i % 2 == 1)
                for (auto& [q, p] : given.joints) q = {-q.w, -q.x, -q.y, -q.z};
            const Hand out = filter.filter(given, i / 60.0);
            for (int j = 0; j < joint_count; ++j) {
                const auto way = rotate(out.joints[j].q, Vec3<float>{1, 0, 0});
                expect_near(way, rotate(unit(hand.joints[j].q), Vec3<float>{1, 0, 0}), 1e-5f);
            }
        }
    }
}

TEST(Filter, AHandIsSteadyAFifthOfASecondAfterItAppeared)
{
    HandFilter filter(Filter::adaptive);
    EXPECT_FALSE(filter.steady());
    for (int i = 0; i <= 30; ++i) {
        filter.filter(hand_at({}), i / 60.0);
        EXPECT_EQ(filter.steady(), i >= 12) << i;
    }
    Hand lost = hand_at({});
    lost.tracked = false;
    EXPECT_FALSE(filter.filter(lost, 31 / 60.0).tracked);
    EXPECT_FALSE(filter.steady());
    for (int i = 32; i <= 50; ++i) {
        filter.filter(hand_at({0.3f, 0, 0}), i / 60.0);
        EXPECT_EQ(filter.steady(), i >= 44) << i;
    }
}

TEST(Filter, ALeapMakesTheHandAppearAnewWithoutLag)
{
    for (const Filter kind : all_filters) {
        HandFilter filter(kind);
        for (int i = 0; i < 30; ++i) filter.filter(hand_at({}), i / 60.0);
        filter.filter(hand_at({0.07f, 0, 0}), 30 / 60.0);
        EXPECT_TRUE(filter.steady());
        Hand one = hand_at({0.07f, 0, 0});
        one.joints[little_tip].p.y += 0.09f;
        const Hand out = filter.filter(one, 31 / 60.0);
        EXPECT_FALSE(filter.steady());
        expect_near(out.joints[wrist].p, one.joints[wrist].p, 1e-6f);
        expect_near(out.joints[little_tip].p, one.joints[little_tip].p, 1e-6f);
    }
}

// A second of a hand that moves so fast [m/s], seen at so many frames a second; whether it touches
// all the time once it is steady.
bool touches_throughout(double rate, double speed)
{
    HandFilter filter(Filter::adaptive);
    bool throughout = true;
    for (int i = 0; i <= int(rate); ++i) {
        filter.filter(hand_at({float(speed * i / rate), 0, 0}), i / rate);
        if (i / rate >= 0.2) throughout = throughout && filter.steady();
    }
    return throughout;
}

TEST(Filter, AHandLeapsByItsSpeedWhateverTheRateOfItsFrames)
{
    for (const double rate : {6.0, 10.0, 30.0, 60.0, 72.0, 90.0, 120.0, 144.0}) {
        EXPECT_TRUE(touches_throughout(rate, 1.4)) << rate << ": as hands move that shape clay";
        EXPECT_EQ(touches_throughout(rate, 4.5), rate > 20) << rate << ": as hands move at most";
        EXPECT_FALSE(touches_throughout(rate, 6)) << rate << ": as no hand moves";
        HandFilter filter(Filter::adaptive);
        for (int i = 0; i <= int(rate); ++i) filter.filter(hand_at({}), i / rate);
        ASSERT_TRUE(filter.steady());
        filter.filter(hand_at({0, 0.3f, 0}), 1 + 1 / rate);
        EXPECT_FALSE(filter.steady()) << rate << ": it may be another hand";
    }
    HandFilter quick(Filter::adaptive);
    for (int i = 0; i < 1000; ++i) quick.filter(hand_at({0.01f * float(i % 2), 0, 0}), 1e-3 * i);
    EXPECT_TRUE(quick.steady()) << "noise between frames that lie close together is no leap";
}

TEST(Filter, CountsWhatIsTakenForANewHandBecauseItsFramesComeTooSeldom)
{
    const auto restarts = [](double rate, double speed) {
        HandFilter filter(Filter::adaptive);
        for (int i = 0; i < 20; ++i)
            filter.filter(hand_at({float(speed * i / rate), 0, 0}), i / rate);
        return filter.slow_restarts();
    };
    EXPECT_EQ(restarts(3, 0), 19) << "none of its frames touches";
    EXPECT_EQ(restarts(6, 1), 0);
    EXPECT_EQ(restarts(6, 2), 19) << "slower than hands may be";
    EXPECT_EQ(restarts(90, 6), 0) << "that is the tracker's, not the rate's";
    HandFilter lost(Filter::adaptive);
    for (int i = 0; i < 10; ++i) {
        lost.filter(hand_at({}), i);
        lost.filter(Hand{}, i + 0.5);
    }
    EXPECT_EQ(lost.slow_restarts(), 0) << "a hand that was lost in between is a new one";
}

TEST(Filter, ALostJointMovesWithTheWrist)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const Filter kind : all_filters) {
        HandFilter filter(kind);
        for (int i = 0; i < 60; ++i) {
            Hand hand = hand_at({0.002f * float(i), 0, 0});
            if (i > 10) {
                hand.valid[index_tip] = false;
                hand.joints[thumb_tip].p.x = nan;  // said to be valid
                hand.joints[palm].q = {0, 0, 0, 0};
            }
            const Hand out = filter.filter(hand, i / 60.0);
            const Hand open = open_hand(right);
            for (const int j : {index_tip, thumb_tip, palm}) {
                const auto from_wrist = out.joints[j].p - out.joints[wrist].p;
                expect_near(from_wrist, open.joints[j].p - open.joints[wrist].p, 2e-3f);
            }
            EXPECT_TRUE(out.tracked);
        }
    }
}

TEST(Filter, AHandWithoutAWristOrNeverSeenWholeIsNotTracked)
{
    HandFilter filter(Filter::adaptive);
    Hand part = hand_at({});
    part.valid[ring_tip] = false;
    EXPECT_FALSE(filter.filter(part, 0).tracked);
    EXPECT_TRUE(filter.filter(hand_at({}), 0.1).tracked);
    EXPECT_TRUE(filter.filter(part, 0.2).tracked);
    Hand severed = hand_at({});
    severed.valid[wrist] = false;
    EXPECT_FALSE(filter.filter(severed, 0.3).tracked);
}

TEST(Filter, TimeThatStandsStillOrRunsBackAddsNothing)
{
    for (const Filter kind : all_filters) {
        HandFilter filter(kind);
        for (int i = 0; i < 20; ++i) filter.filter(hand_at({}), i / 60.0);
        const Hand before = filter.filter(hand_at({0.01f, 0, 0}), 20 / 60.0);
        for (const double time : {20 / 60.0, 0.1, -5.0, std::nan("")}) {
            const Hand out = filter.filter(hand_at({0.03f, 0, 0}), time);
            expect_near(out.joints[palm].p, before.joints[palm].p, 1e-9f);
        }
    }
}

Recording line_along_x()  // one frame each tenth of a second, along x, 4 cm a frame
{
    Recording r{"line", 10, 0, {}};
    for (int i = 0; i < 30; ++i) {
        HandFrame frame;
        frame.time = 0.1 * i;
        frame.hand[left] = frame.hand[right] = hand_at({0.04f * float(i), 0, 0});
        if (i >= 10 && i < 14) frame.hand[left].tracked = false;
        r.frames.push_back(frame);
    }
    return r;
}

TEST(HandSource, SamplesBetweenFramesInTheSimulationsFrameAndSize)
{
    HandsOptions options;
    options.filter = Filter::none;
    options.zoom = 2.5;
    options.at = {0.5, 0.4, 0.3};
    const HandSource source(line_along_x(), options);
    EXPECT_DOUBLE_EQ(source.duration(), 2.9);
    Joint<double> joints[2 * joint_count];
    float size[2];
    EXPECT_TRUE(source.sample(0.525, joints, size));
    const Hand open = open_hand(right);
    for (int j = 0; j < joint_count; ++j) {
        const auto real = cast<double>(open.joints[j].p) + Vec3<double>{0.04 * 5.25, 0, 0};
        EXPECT_LT(length(joints[joint_count + j].p - (options.at + 2.5 * real)), 1e-6);
        const Quat<double> q = joints[joint_count + j].q;
        EXPECT_NEAR(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z, 1, 1e-12);
    }
}

TEST(HandSource, IsInactiveUntilSteadyWhileLostAndAfterTheEnd)
{
    HandsOptions options;
    HandSource source(line_along_x(), options);
    Joint<double> joints[2 * joint_count];
    float size[2];
    const auto left_at = [&](double time) {
        return source.sample(time, joints, size), size[left] > 0;
    };
    EXPECT_FALSE(left_at(0.15));
    EXPECT_TRUE(left_at(0.35));
    EXPECT_TRUE(left_at(0.85));
    EXPECT_FALSE(left_at(0.95));  // the next frame has lost the hand
    EXPECT_GT(size[right], 0);
    EXPECT_FALSE(left_at(1.2));
    EXPECT_FLOAT_EQ(size[right], 1);
    EXPECT_FALSE(left_at(1.45));  // back, but only just
    EXPECT_TRUE(left_at(1.65));   // and grows
    EXPECT_GT(size[left], 0);
    EXPECT_LT(size[left], 0.5);
    EXPECT_TRUE(left_at(1.75));
    EXPECT_TRUE(left_at(2.9));
    EXPECT_FALSE(source.sample(2.95, joints, size));
    for (const auto& [q, p] : joints) EXPECT_TRUE(std::isfinite(p.x) && std::isfinite(q.w));
    options.present[left] = false;
    source = HandSource(line_along_x(), options);
    EXPECT_TRUE(source.sample(0.35, joints, size));
    EXPECT_EQ(size[left], 0);
}

TEST(HandSource, ARecordingOfNoHandsIsNeverActiveAndStillFinite)
{
    Recording r{"nobody", 60, 0, {}};
    for (int i = 0; i < 5; ++i) r.frames.push_back({i / 60.0, {}});
    const HandSource source(r, {});
    Joint<double> joints[2 * joint_count];
    float size[2];
    EXPECT_FALSE(source.sample(0.03, joints, size));
    for (const auto& [q, p] : joints) EXPECT_DOUBLE_EQ(q.w, 1);
    r.frames.clear();
    EXPECT_THROW(HandSource(r, {}), InputError);
}

TEST(HandStream, HoldsTheLastHandsForAWhileAndForgetsOldOnes)
{
    HandsOptions options;
    options.zoom = 2;
    HandStream stream(options);
    Joint<double> joints[2 * joint_count];
    float size[side_count];
    EXPECT_FALSE(stream.sample(0, joints, size));
    EXPECT_EQ(joints[0].q.w, 1);
    HandFrame frame;
    frame.hand[left] = open_hand(left);
    frame.hand[left].tracked = true;
    frame.hand[left].valid.fill(true);
    for (int i = 0; i <= 100; ++i) frame.time = 0.01 * i, stream.push(frame);
    frame.time = 0.5;
    stream.push(frame);
    frame.time = std::nan("");
    stream.push(frame);
    EXPECT_DOUBLE_EQ(stream.newest(), 1);
    EXPECT_TRUE(stream.sample(1.2, joints, size));
    EXPECT_EQ(size[left], 1);
    EXPECT_EQ(size[right], 0);
    EXPECT_FALSE(stream.sample(1.3, joints, size));
    stream.forget(0.9);
    EXPECT_TRUE(stream.sample(0.95, joints, size));
    stream.close();
    EXPECT_FALSE(stream.sample(1.01, joints, size));
    EXPECT_TRUE(stream.sample(1, joints, size));
}

}  // namespace
}  // namespace knead
