// Objects that are added and put down by hand or with the mouse.
#include "host/ui/place_gesture.h"

#include <gtest/gtest.h>

namespace knead {
namespace {

using V = Vec3<double>;

SceneObject box()
{
    SceneObject object;
    object.source.shape = ShapeKind::box, object.source.size = {0.2, 0.4, 0.6};
    object.pose = {{1, 0, 0, 0}, {9, 9, 9}};
    return object;
}

void near(V a, V b) { EXPECT_LT(length(a - b), 1e-9) << a.x << " " << a.y << " " << a.z; }

PlaceGesture::Input hands()
{
    PlaceGesture::Input input;
    input.hands[right].tracked = true, input.hands[right].at.p = {1, 2, 3};
    return input;
}

TEST(PlaceGesture, AnObjectIsAtTheHandUntilItsPinchOpens)
{
    PlaceGesture gesture;
    auto input = hands();
    EXPECT_EQ(gesture.frame(input), PlaceGesture::goes_on);
    near(*gesture.at(), {1, 2, 3});
    input.hands[right].pinches = true;
    EXPECT_EQ(gesture.frame(input), PlaceGesture::goes_on);
    input.hands[right].at.p = {1, 2, 4};
    EXPECT_EQ(gesture.frame(input), PlaceGesture::goes_on);
    input.hands[right].pinches = false;
    EXPECT_EQ(gesture.frame(input), PlaceGesture::placed);
    near(*gesture.at(), {1, 2, 4});
}

TEST(PlaceGesture, AHandThatPinchesAlreadyMustOpenFirst)
{
    PlaceGesture gesture;
    auto input = hands();
    input.hands[right].pinches = true;
    EXPECT_EQ(gesture.frame(input), PlaceGesture::goes_on);
    input.hands[right].pinches = false;
    EXPECT_EQ(gesture.frame(input), PlaceGesture::goes_on);
    EXPECT_EQ(gesture.frame(input), PlaceGesture::goes_on);
}

TEST(PlaceGesture, TheHandThatPinchesHasItAndALostOneLeavesIt)
{
    PlaceGesture gesture;
    auto input = hands();
    input.hands[left].tracked = true, input.hands[left].at.p = {-1, 0, 0};
    gesture.frame(input);
    near(*gesture.at(), {1, 2, 3});
    input.hands[left].pinches = true;
    gesture.frame(input);
    near(*gesture.at(), {-1, 0, 0});
    input.hands[left].tracked = false;
    EXPECT_EQ(gesture.frame(input), PlaceGesture::goes_on);
    near(*gesture.at(), {-1, 0, 0});
    input.hands[left].tracked = true, input.hands[left].pinches = false;
    input.hands[left].at.p = {-1.004, 0.006, 0}, input.snaps = true;
    EXPECT_EQ(gesture.frame(input), PlaceGesture::placed);
    near(*gesture.at(), {-1, 0.01, 0});
}

TEST(PlaceGesture, IsCancelled)
{
    PlaceGesture gesture;
    auto input = hands();
    EXPECT_FALSE(gesture.at());
    input.cancels = true;
    EXPECT_EQ(gesture.frame(input), PlaceGesture::cancelled);
}

TEST(Placing, ABoxRestsOnWhatIsBelowThePointer)
{
    near(resting_on(box(), {{1, 0, 1}, {0, 1, 0}}, 0.01), {1, 0.21, 1});
    near(resting_on(box(), {{1, 0, 1}, {-1, 0, 0}}, 0), {0.9, 0, 1});
    SceneObject turned = box();
    turned.pose.q = turn_about(V{0, 0, 1}, std::acos(-1.0) / 2);
    near(resting_on(turned, {{0, 0, 0}, {0, 1, 0}}, 0), {0, 0.1, 0});
    near(placed(box(), {1, 2, 3}, {10, 0, 0}).pose.p, {11, 2, 3});
}

TEST(Placing, TheOutlineIsAroundTheObject)
{
    SceneObject ball;
    ball.source.shape = ShapeKind::sphere, ball.source.size = {0.2, 0.2, 0.2};
    const Mesh corners = object_outline(box(), {1, 2, 3}, 0.001),
               wires = object_outline(ball, {1, 2, 3}, 0.001);
    EXPECT_GT(wires.triangles.size(), corners.triangles.size());
    for (const Vec3<float>& p : corners.vertices) {
        EXPECT_LT(std::abs(p.x - 1), 0.102f);
        EXPECT_LT(std::abs(p.y - 2), 0.202f);
        EXPECT_LT(std::abs(p.z - 3), 0.302f);
    }
}

}  // namespace
}  // namespace knead
