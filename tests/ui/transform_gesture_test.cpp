// Gestures that move, turn and scale objects: what mouse and keys do, and the command at the end.
#include "host/ui/transform_gesture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/ui/arrange.h"

namespace knead {
namespace {

using V = Vec3<double>;

// From in front of the origin, 2 m away; through (x, y, 0).
TransformView through(double x, double y) { return {{0, 0, 2}, {0, 0, -1}, {x, y, -2}}; }

void near(V a, V b, double within = 1e-9)
{
    EXPECT_LT(length(a - b), within) << a.x << " " << a.y << " " << a.z;
}

void type(TransformGesture& g, const std::string& text)
{
    for (const char c : text) EXPECT_TRUE(g.type(c)) << c;
}

TransformGesture moving() { return {TransformKind::move, {ObjectId{3}}, {}, through(0.1, 0)}; }

TEST(TransformGesture, AMoveFollowsThePointerInThePlaneOfTheView)
{
    TransformGesture g = moving();
    near(g.by(), {});
    EXPECT_FALSE(g.command({})) << "nothing has moved";
    g.point(through(0.3, 0.2), false);
    near(g.by(), {0.2, 0.2, 0});
    near(g.at({1, 1, 1}, {}), {1.2, 1.2, 1});
    EXPECT_TRUE(g.axes().empty());
    EXPECT_NE(g.text().find("x 20.00 y 20.00 z 0.00 cm"), std::string::npos) << g.text();
    g.choose_axis(0, false);
    near(g.by(), {0.2, 0, 0});
    ASSERT_EQ(g.axes().size(), 1u);
    EXPECT_NE(g.text().find("along x: 20.00 cm"), std::string::npos) << g.text();
    g.choose_axis(0, false);
    near(g.by(), {0.2, 0.2, 0});
    g.choose_axis(0, true);
    near(g.by(), {0, 0.2, 0});
    ASSERT_EQ(g.axes().size(), 2u);
    const auto command = std::get<MoveObjects>(*g.command({5, 5, 5}));
    EXPECT_EQ(std::get<ObjectId>(command.objects.at(0).by), ObjectId{3});
    near(*command.by, {0, 0.2, 0});
    EXPECT_FALSE(command.turn || command.about);
}

// Along an axis the object stays below the pointer, from any side.
TEST(TransformGesture, AnAxisIsFollowedInDepth)
{
    const V eye{1, 1, 2}, forward = (-1 / std::sqrt(6.0)) * eye;
    const auto at = [&](V x) { return TransformView{eye, forward, x - eye}; };
    for (int axis = 0; axis < 3; ++axis) {
        TransformGesture g(TransformKind::move, {ObjectId{1}}, {}, at({}));
        g.choose_axis(axis, false);
        const V to{axis == 0 ? 0.3 : 0, axis == 1 ? 0.3 : 0, axis == 2 ? 0.3 : 0};
        g.point(at(to), false);
        near(g.by(), to);
        TransformGesture plane(TransformKind::move, {ObjectId{1}}, {}, at({}));
        plane.choose_axis(axis, true);
        const V there = V{0.2, 0.2, 0.2} - (2.0 / 3) * to;
        plane.point(at(there), false);
        near(plane.by(), there);
    }
    // An axis that points to the eye, or a plane that is seen from its edge, does not throw it
    // away.
    TransformGesture g = moving();
    g.choose_axis(2, false);
    g.point(through(0.4, 0.4), false);
    EXPECT_LT(length(g.by()), 1);
    g.choose_axis(1, true);
    g.point(through(0.4, 0.4), false);
    EXPECT_LT(length(g.by()), 1);
}

TEST(TransformGesture, NumbersAreTypedInCentimetres)
{
    TransformGesture g = moving();
    g.choose_axis(1, false);
    type(g, "12.5");
    near(g.by(), {0, 0.125, 0});
    g.point(through(0.9, 0.9), false);
    near(g.by(), {0, 0.125, 0});
    g.type('-');
    near(g.by(), {0, -0.125, 0});
    g.type('-');
    g.erase(), g.erase();
    near(g.by(), {0, 0.12, 0});
    EXPECT_NE(g.text().find("along y: 12 cm"), std::string::npos) << g.text();
    for (int i = 0; i < 5; ++i) g.erase();
    EXPECT_FALSE(g.typed());
    near(g.by(), {0, 0.9, 0});
    EXPECT_FALSE(g.type('q'));
    type(g, "1,5");
    EXPECT_TRUE(g.type('.')) << "without effect";
    near(g.by(), {0, 0.015, 0});
    type(g, std::string(40, '9'));
    EXPECT_TRUE(std::isfinite(g.by().y));
    TransformGesture free = moving();
    type(free, "2");
    near(free.by(), {0.02, 0, 0});
    free.choose_axis(0, true);
    near(free.by(), {0, 0.02, 0});
    TransformGesture sign = moving();
    sign.type('-'), sign.type('.');
    EXPECT_FALSE(sign.command({})) << "no digit";
}

TEST(TransformGesture, MovesSnapToCentimetresAndTurnsTo15Degrees)
{
    TransformGesture g = moving();
    g.point(through(0.1234, 0.0271), true);
    near(g.by(), {0.02, 0.03, 0});
    TransformGesture turn(TransformKind::turn, {ObjectId{1}}, {}, through(0.5, 0));
    const double a = 40 * std::numbers::pi / 180;
    turn.point(through(0.5 * std::cos(a), 0.5 * std::sin(a)), true);
    EXPECT_NEAR(turn.angle(), 45 * std::numbers::pi / 180, 1e-9);
    TransformGesture scale(TransformKind::scale, {ObjectId{1}}, {}, through(0.5, 0));
    scale.point(through(0.73, 0), true);
    EXPECT_NEAR(scale.factor(), 1.5, 1e-12);
}

TEST(TransformGesture, ATurnGoesWithThePointerAroundTheCentre)
{
    TransformGesture g(TransformKind::turn, {ObjectId{1}, ObjectId{2}}, {}, through(0.5, 0));
    for (int degrees = 0; degrees <= 500; degrees += 20) {
        const double a = degrees * std::numbers::pi / 180;
        g.point(through(0.5 * std::cos(a), 0.5 * std::sin(a)), false);
    }
    EXPECT_NEAR(g.angle(), 500 * std::numbers::pi / 180, 1e-9) << "more than once";
    // About an axis towards the eye the same, away from it the other way around.
    g.choose_axis(2, false);
    EXPECT_NEAR(g.turn().z, std::sin(250 * std::numbers::pi / 180), 1e-9);
    g.choose_axis(1, true);
    EXPECT_EQ(g.axes().size(), 1u) << "a turn has no plane";
    type(g, "90");
    near(g.at({1, 0, 0}, {}), {0, 0, -1});
    EXPECT_NE(g.text().find("Turn about y: 90 degrees"), std::string::npos) << g.text();
    const auto command = std::get<MoveObjects>(*g.command({1, 2, 3}));
    near(*command.about, {1, 2, 3});
    EXPECT_NEAR(command.turn->y, std::sqrt(0.5), 1e-12);
    EXPECT_EQ(command.objects.size(), 2u);
    EXPECT_FALSE(command.by);
    for (int i = 0; i < 2; ++i) g.erase();
    type(g, "360");
    EXPECT_FALSE(g.command({})) << "nothing has turned";
    // Through the centre the pointer has no angle.
    TransformGesture still(TransformKind::turn, {ObjectId{1}}, {}, through(0, 0));
    EXPECT_EQ(still.angle(), 0);
    still.point(through(0, 0.4), false);
    EXPECT_EQ(still.angle(), 0);
}

TEST(TransformGesture, AFactorIsTheRatioOfDistancesFromTheCentre)
{
    TransformGesture g(TransformKind::scale, {ObjectId{1}}, {0, 0, 0}, through(0.2, 0));
    g.choose_axis(1, false);
    EXPECT_EQ(g.axis(), -1) << "scaling is even";
    g.point(through(0, 0.5), false);
    EXPECT_NEAR(g.factor(), 2.5, 1e-12);
    near(g.at({0.1, 0, 0}, {}), {0.25, 0, 0});
    near(g.at({0.1, 0, 0}, {0.1, 0, 0}), {0.1, 0, 0});
    EXPECT_NEAR(std::get<ScaleObjects>(*g.command({})).factor, 2.5, 1e-12);
    // By the pointer no factor that the command refuses; a typed one is what it says.
    g.point(through(0, 1e-9), false);
    EXPECT_EQ(g.factor(), TransformGesture::least_factor);
    g.point(through(20, 0), false);
    EXPECT_EQ(g.factor(), TransformGesture::largest_factor);
    type(g, "0");
    EXPECT_EQ(std::get<ScaleObjects>(*g.command({})).factor, 0);
    type(g, "1000");
    EXPECT_EQ(std::get<ScaleObjects>(*g.command({})).factor, 1000);
    TransformGesture middle(TransformKind::scale, {ObjectId{1}}, {}, through(0, 0));
    middle.point(through(0.1, 0), false);
    EXPECT_TRUE(std::isfinite(middle.factor()));
    type(middle, "1");
    EXPECT_FALSE(middle.command({}));
}

// The lowest point, towards the surface, comes to the point below the pointer.
TEST(TransformGesture, OnASurfaceTheLowestPointTouches)
{
    TransformGesture g(TransformKind::move, {ObjectId{1}}, {0, 0.5, 0}, through(0, 0.5));
    g.set_clay({{0, 0.4f, 0}, {0, 0.6f, 0}, {0.1f, 0.5f, 0}, {-0.1f, 0.5f, 0}}, 0.01);
    g.point(through(0, 0), false, TransformSurface{{0.3, 0, 0.2}, {0, 1, 0}});
    near(g.at({0, 0.4, 0}, {}), {0.3, 0.01, 0.2}, 1e-7);
    EXPECT_NE(g.text().find("on the surface"), std::string::npos) << g.text();
    const double h = std::sqrt(0.5);
    g.point(through(0, 0), false, TransformSurface{{0.3, 0, 0.2}, {h, h, 0}});
    near(g.at({0, 0.5, 0}, {}), V{0.3, 0, 0.2} + (0.1 * h + 0.01) * V{h, h, 0}, 1e-7);
    g.choose_axis(1, false);
    EXPECT_EQ(g.by().x, 0);
    g.point(through(0, 0.6), false);
    near(g.by(), {0, 0.1, 0});
}

ObjectPlace place(unsigned id, V low, V high)
{
    return {{id}, {low, high}, 0.5 * (low + high), 0.01, {}};
}

TEST(Arrange, ACopyIsPutToTheNearestFreePlaceBesideTheObject)
{
    ObjectPlaces places;
    places.all = {place(1, {0.4, 0, 0.4}, {0.6, 0.1, 0.6})};
    const Surroundings around{places, {{0, 0, 0}, {1, 1, 1}}, 0.05};
    near(beside(around, {ObjectId{1}}), {0.25, 0, 0}, 1e-3);
    places.all.push_back(place(2, {0.7, 0, 0.4}, {0.8, 0.1, 0.6}));
    near(beside(around, {ObjectId{1}}), {-0.25, 0, 0}, 1e-3);
    places.all.push_back(place(3, {0.1, 0, 0.4}, {0.3, 0.1, 0.6}));
    near(beside(around, {ObjectId{1}}), {0, 0, 0.25}, 1e-3);
    near(beside(around, {ObjectId{1}, ObjectId{2}}), {0, 0, 0.25}, 1e-3);
    // Above, where the table is full; where nothing is free, the first place: it is refused.
    places.all.push_back(place(4, {0, 0, 0}, {1, 0.1, 0.3}));
    places.all.push_back(place(5, {0, 0, 0.7}, {1, 0.1, 1}));
    near(beside(around, {ObjectId{1}}), {0, 0.15, 0}, 1e-3);
    places.all.push_back(place(6, {0, 0.2, 0}, {1, 1, 1}));
    near(beside(around, {ObjectId{1}}), {0.25, 0, 0}, 1e-3);
    near(beside(around, {ObjectId{9}}), {});
}

TEST(Arrange, TheMiddleIsAboveWhatIsThere)
{
    ObjectPlaces places;
    places.all = {place(1, {0, 0, 0}, {0.2, 0.1, 0.2})};
    const Surroundings around{places, {{0, 0, 0}, {1, 1, 1}}, 0.05};
    near(to_middle(around, {ObjectId{1}}), {0.4, 0, 0.4});
    places.all.push_back(place(2, {0.45, 0, 0.45}, {0.5, 0.3, 0.5}));
    near(to_middle(around, {ObjectId{1}}), {0.4, 0.35, 0.4}, 1e-3);
    places.all.push_back(place(3, {0.45, 0.4, 0.45}, {0.5, 0.5, 0.5}));
    near(to_middle(around, {ObjectId{1}}), {0.4, 0.55, 0.4}, 1e-3);
    places.all.push_back(place(4, {0.45, 0.6, 0.45}, {0.5, 0.98, 0.5}));
    near(to_middle(around, {ObjectId{1}}), {0.4, 0, 0.4});
}

}  // namespace
}  // namespace knead
