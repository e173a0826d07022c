// Pinches that choose and move objects: what they mean, the motion, and the commands at the end.
#include "host/ui/grab_gesture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "cuda/math/rotation.h"

namespace knead {
namespace {

using V = Vec3<double>;
using Q = Quat<double>;

constexpr double degree = std::numbers::pi / 180;

void near(V a, V b, double within = 1e-9)
{
    EXPECT_LT(length(a - b), within) << a.x << " " << a.y << " " << a.z;
}

Q about_y(double degrees) { return turn_about(V{0, 1, 0}, degree * degrees); }

// Two hands in front of objects, frame by frame.
struct Hands {
    GrabGesture gesture;
    GrabInput input;

    Hands()
    {
        for (GrabHand& hand : input.hands) hand.tracked = true;
        input.hands[left].at.p = {-0.2, 0, 0};
        input.hands[right].at.p = {0.2, 0, 0};
    }
    GrabHand& hand(Side side) { return input.hands[side]; }
    void over(Side side, unsigned object)
    {
        hand(side).hovers.reset();
        if (object) hand(side).hovers = Hovered{{object}, {}, 0, true};
    }
    GrabAnswer pinch(Side side, bool on)
    {
        hand(side).pinches = on;
        return frame();
    }
    GrabAnswer frame()
    {
        input.time += 1.0 / 90;
        const GrabAnswer answer = gesture.frame(input);
        std::vector<ObjectId>& chosen = input.chosen;
        if (answer.choice == GrabAnswer::alone) chosen = {answer.object};
        if (answer.choice == GrabAnswer::none) chosen.clear();
        if (answer.choice == GrabAnswer::more) chosen.push_back(answer.object);
        if (answer.choice == GrabAnswer::less) std::erase(chosen, answer.object);
        return answer;
    }
    void click(Side side, unsigned object)
    {
        over(side, object);
        pinch(side, true), frame(), pinch(side, false);
    }
    std::vector<unsigned> chosen() const
    {
        std::vector<unsigned> all;
        for (const ObjectId id : input.chosen) all.push_back(id.value);
        return all;
    }
};

using Ids = std::vector<unsigned>;

TEST(GrabGesture, APinchChoosesOneAndOneInTheAirNone)
{
    Hands h;
    h.click(right, 3);
    EXPECT_EQ(h.chosen(), Ids{3});
    h.click(right, 5);
    EXPECT_EQ(h.chosen(), Ids{5});
    h.click(right, 0);
    EXPECT_EQ(h.chosen(), Ids{});
    EXPECT_FALSE(h.gesture.pinches());
}

TEST(GrabGesture, TheSupportHandAddsAndTakesAway)
{
    Hands h;
    h.click(right, 3), h.click(left, 5);
    EXPECT_EQ(h.chosen(), (Ids{3, 5}));
    h.click(left, 0);
    EXPECT_EQ(h.chosen(), (Ids{3, 5})) << "in the air it has no effect";
    h.click(left, 3);
    EXPECT_EQ(h.chosen(), Ids{5});
    h.input.adds_always = true;
    h.click(right, 3);
    EXPECT_EQ(h.chosen(), (Ids{5, 3}));
    h.input.adds_always = false;
    h.click(right, 3);
    EXPECT_EQ(h.chosen(), Ids{3}) << "one of several, alone";
}

TEST(GrabGesture, AStillHandChoosesAndDoesNotMove)
{
    Hands h;
    h.over(right, 3);
    h.pinch(right, true);
    h.hand(right).at.p.x += 0.9 * GrabGesture::still;
    EXPECT_FALSE(h.frame().begins);
    EXPECT_FALSE(h.gesture.moves());
    const GrabAnswer end = h.pinch(right, false);
    EXPECT_FALSE(end.ends);
    // In a zoomed scene the same way of the hand is a larger one of the clay.
    h.input.scale = 10;
    h.pinch(right, true);
    h.hand(right).at.p.x += 9 * GrabGesture::still;
    EXPECT_FALSE(h.frame().begins);
}

TEST(GrabGesture, AnObjectFollowsThePinchInPlaceAndTurn)
{
    Hands h;
    h.over(right, 3);
    h.pinch(right, true);
    const Joint<double> from = h.hand(right).at;
    h.hand(right).at = {about_y(90), from.p + V{0, 0.3, 0}};
    EXPECT_TRUE(h.frame().begins);
    EXPECT_TRUE(h.gesture.moves());
    near(h.gesture.motion().at(from.p), from.p + V{0, 0.3, 0});
    near(h.gesture.motion().at(from.p + V{0.1, 0, 0}), from.p + V{0, 0.3, -0.1});
    EXPECT_NEAR(h.gesture.motion().scale, 1, 1e-12);
    const GrabAnswer end = h.pinch(right, false);
    EXPECT_TRUE(end.ends);
    EXPECT_EQ(end.choice, GrabAnswer::unchanged) << "it stays chosen";
    EXPECT_EQ(h.chosen(), Ids{3});
    near(h.gesture.motion().at(from.p), from.p + V{0, 0.3, 0}, 1e-9);
    EXPECT_FALSE(h.gesture.moves());
}

TEST(GrabGesture, ADragOfOneOfSeveralChosenMovesAll)
{
    Hands h;
    h.click(right, 3), h.click(left, 5);
    h.over(right, 3);
    h.pinch(right, true);
    h.hand(right).at.p.y += 0.1;
    EXPECT_TRUE(h.frame().begins);
    EXPECT_EQ(h.chosen(), (Ids{3, 5}));
}

TEST(GrabGesture, TwoPinchesMoveTurnAndScale)
{
    Hands h;
    h.over(right, 3);
    h.pinch(right, true);
    h.over(left, 0);
    EXPECT_TRUE(h.pinch(left, true).begins) << "the second hand need not touch it";
    h.hand(left).at.p = {0, 0.1, 0.4}, h.hand(right).at.p = {0, 0.1, -0.4};
    h.frame();
    const Similarity m = h.gesture.motion();
    EXPECT_NEAR(m.scale, 2, 1e-9);
    near(m.at({-0.2, 0, 0}), {0, 0.1, 0.4});
    near(m.at({0.2, 0, 0}), {0, 0.1, -0.4});
    near(m.at({0, 0, 0}), {0, 0.1, 0});
    near(m.at({0, 0.1, 0}), {0, 0.3, 0}, 1e-9);
    // A hand that leaves changes nothing, and the other goes on.
    h.pinch(left, false);
    near(h.gesture.motion().at({-0.2, 0, 0}), {0, 0.1, 0.4}, 1e-9);
    h.hand(right).at.p = h.hand(right).at.p + V{0.05, 0, 0};
    h.frame();
    near(h.gesture.motion().at({0, 0, 0}), {0.05, 0.1, 0}, 1e-9);
    EXPECT_NEAR(h.gesture.motion().scale, 2, 1e-9);
    EXPECT_TRUE(h.pinch(right, false).ends);
}

TEST(GrabGesture, BothWristsTurnAnObjectAboutTheLineBetweenThem)
{
    Joint<double> from[side_count] = {{{1, 0, 0, 0}, {-1, 0, 0}}, {{1, 0, 0, 0}, {1, 0, 0}}};
    Joint<double> to[side_count] = {from[left], from[right]};
    to[left].q = turn_about(V{1, 0, 0}, 20 * degree);
    to[right].q = turn_about(V{1, 0, 0}, 40 * degree);
    const Similarity m = motion_between(from, to);
    near(m.at({0, 1, 0}), {0, std::cos(30 * degree), std::sin(30 * degree)});
    // Hands that change places turn it by half a turn.
    to[left] = {about_y(180), {1, 0, 0}}, to[right] = {about_y(180), {-1, 0, 0}};
    const Similarity half = motion_between(from, to);
    near(half.at({-1, 0, 0}), {1, 0, 0});
    near(half.at({0, 1, 0}), {0, 1, 0});
    // Without a distance there is neither direction nor scale.
    to[left].p = to[right].p = {0, 2, 0};
    EXPECT_EQ(motion_between(from, to).scale, 1);
}

TEST(GrabGesture, ALostHandHoldsForAMomentThenCancels)
{
    Hands h;
    h.over(right, 3);
    h.pinch(right, true);
    h.hand(right).at.p.y += 0.2;
    h.frame();
    h.hand(right).tracked = h.hand(right).pinches = false;
    for (int k = 0; k < 30; ++k) EXPECT_FALSE(h.frame().cancelled);
    near(h.gesture.motion().at({0.2, 0, 0}), {0.2, 0.2, 0});
    h.hand(right).tracked = h.hand(right).pinches = true;
    h.frame();
    EXPECT_TRUE(h.gesture.moves());
    h.hand(right).tracked = false;
    bool cancelled = false;
    for (int k = 0; k < 60; ++k) cancelled = h.frame().cancelled || cancelled;
    EXPECT_TRUE(cancelled);
    EXPECT_FALSE(h.gesture.pinches());
    h.hand(right).tracked = true;
    EXPECT_FALSE(h.frame().begins) << "the old pinch begins nothing";
    EXPECT_FALSE(h.gesture.pinches());
}

TEST(GrabGesture, ACancelledMotionEndsWithoutEffect)
{
    Hands h;
    h.over(right, 3);
    h.pinch(right, true);
    h.hand(right).at.p.y += 0.2;
    h.frame();
    h.input.cancels = true;
    const GrabAnswer answer = h.frame();
    EXPECT_TRUE(answer.cancelled);
    EXPECT_FALSE(answer.ends);
    h.input.cancels = false;
    EXPECT_FALSE(h.pinch(right, false).ends);
    EXPECT_EQ(h.chosen(), Ids{3});
}

TEST(GrabGesture, SimilaritiesFollowEachOther)
{
    std::mt19937 source(4);
    std::uniform_real_distribution<double> in(-1, 1);
    const auto random = [&] {
        Similarity s;
        s.scale = 1.5 + in(source);
        s.turn = unit(Q{in(source), in(source), in(source), in(source)});
        s.by = {in(source), in(source), in(source)};
        return s;
    };
    for (int k = 0; k < 20; ++k) {
        const Similarity a = random(), b = random();
        const V x{in(source), in(source), in(source)};
        near(then(a, b).at(x), b.at(a.at(x)), 1e-12);
    }
}

ObjectMotion moved(const Similarity& s, bool snaps = false)
{
    return object_motion(s, {1, 0, 0}, snaps);
}

TEST(ObjectMotion, SendsOneMoveWithWhatItHas)
{
    Similarity s;
    s.by = {0.1, 0, 0};
    const auto only = moved(s).commands({ObjectId{3}}, {5, 5, 5});
    ASSERT_EQ(only.size(), 1u);
    const MoveObjects& by = std::get<MoveObjects>(only[0]);
    EXPECT_EQ(std::get<ObjectId>(by.objects.at(0).by), ObjectId{3});
    near(*by.by, {0.1, 0, 0});
    EXPECT_FALSE(by.turn || by.about);

    s.turn = about_y(90);
    const auto turned = moved(s).commands({ObjectId{3}}, {5, 5, 5});
    ASSERT_EQ(turned.size(), 1u);
    const MoveObjects& all = std::get<MoveObjects>(turned[0]);
    ASSERT_TRUE(all.turn && all.about && all.by);
    near(*all.about, {6, 5, 5});
    near(*all.by, V{-0.9, 0, -1});  // the centre goes with the hand
    EXPECT_TRUE(moved({}).commands({ObjectId{3}}, {}).empty());
}

// A larger object is moved first, a smaller one scaled first: in between it is nowhere larger than
// before or after.
TEST(ObjectMotion, ScalesBeforeOrAfterTheMove)
{
    Similarity s;
    s.scale = 2, s.by = {0, 1, 0};
    const auto grown = moved(s).commands({ObjectId{3}}, {});
    ASSERT_EQ(grown.size(), 2u);
    EXPECT_TRUE(std::holds_alternative<MoveObjects>(grown[0]));
    EXPECT_EQ(std::get<ScaleObjects>(grown[1]).factor, 2);
    near(*std::get<MoveObjects>(grown[0]).by, {1, 1, 0});
    s.scale = 0.5;
    const auto shrunk = moved(s).commands({ObjectId{3}}, {});
    ASSERT_EQ(shrunk.size(), 2u);
    EXPECT_EQ(std::get<ScaleObjects>(shrunk[0]).factor, 0.5);
    s.scale = 1000;
    EXPECT_EQ(moved(s).factor, TransformGesture::largest_factor);
    // The preview: about its own centre, which the motion takes along.
    s = {2, about_y(180), {0, 0, 0}};
    near(moved(s).at({1, 0, 0}, {1, 0, 0}), {-2, 0, 0});
    near(moved(s).at({1.1, 0, 0}, {1, 0, 0}), {-2.2, 0, 0});
}

TEST(ObjectMotion, SnapsAsTheWindowDoes)
{
    Similarity s;
    s.scale = 1.26, s.by = {0.123, -0.004, 0};
    // Nearly about y.
    s.turn = unit(turn_about(V{0.1, 0, 0.02}, 1.0) * about_y(40));
    s.by = s.by + V{1, 0, 0} - s.scale * rotate(s.turn, V{1, 0, 0});
    const ObjectMotion m = moved(s, true);
    EXPECT_NEAR(m.factor, 1.3, 1e-12);
    near(m.by, {0.12, 0, 0});
    near(rotate(m.turn, V{0, 1, 0}), {0, 1, 0});
    near(rotate(m.turn, V{1, 0, 0}), rotate(about_y(45), V{1, 0, 0}));
    EXPECT_EQ(m.by.x, Snapping::move(V{0.123, 0, 0}).x);
    EXPECT_NE(m.text().find("turn 45 degrees, scale 1.30"), std::string::npos) << m.text();
}

}  // namespace
}  // namespace knead
