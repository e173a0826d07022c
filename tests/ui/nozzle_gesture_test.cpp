// Clay laid with the mouse: where it begins and goes, and its commands.
#include "host/ui/nozzle_gesture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace knead {
namespace {

TransformView from_above(double x, double z)
{
    const Vec3<double> eye{0.5, 1.5, 0.5};
    return {eye, {0, -1, 0}, Vec3<double>{x, 0, z} - eye};
}
const NozzleTool rope{"rope", SectionKind::star, 0.06, {}, 2};

TEST(NozzleGesture, LaysClayOnTheSurfaceWhereItBegan)
{
    const Vec3<double> origin{10, 20, 30};
    NozzleGesture g(rope, from_above(0.2, 0.5), {{0.2, 0, 0.5}, {0, 1, 0}}, origin);
    const SourceBegin begins = g.begin();
    EXPECT_EQ(begins.name, "rope");
    EXPECT_EQ(begins.section, SectionKind::star);
    EXPECT_EQ(begins.diameter, 0.06);
    EXPECT_EQ(begins.category, 2);
    EXPECT_TRUE(equal(begins.at, Vec3<double>{0.2, 0.03, 0.5} + origin));
    // The ray through a place of the floor meets the plane 3 cm above it nearer to the eye.
    const auto moves = g.move(from_above(0.6, 0.5));
    ASSERT_TRUE(moves);
    EXPECT_EQ(std::get<std::string>(moves->object.by), "rope");
    EXPECT_NEAR(moves->at.y, 20.03, 1e-12);
    EXPECT_NEAR(moves->at.x, 10.5 + 0.1 * 1.47 / 1.5, 1e-12);
    EXPECT_NEAR(moves->at.z, 30.5, 1e-12);
    EXPECT_FALSE(g.move(from_above(0.602, 0.5)));
    EXPECT_TRUE(g.move(from_above(0.61, 0.5)));
    EXPECT_EQ(std::get<std::string>(g.end().object.by), "rope");
}

// A wall seen from its edge would take the nozzle far away.
TEST(NozzleGesture, GoesAcrossTheGazeOnSurfacesThatAreSeenFlat)
{
    const Vec3<double> eye{0, 0.1, 2};
    const auto view = [&](double x, double y) {
        return TransformView{eye, {0, 0, -1}, Vec3<double>{x, y, 0} - eye};
    };
    NozzleGesture g(rope, view(0, 0), {{0, 0, 0}, {0, 1, 0}}, {});
    const auto moves = g.move(view(0.3, 0.2));
    ASSERT_TRUE(moves);
    EXPECT_NEAR(moves->at.z, 0, 1e-12);
    EXPECT_NEAR(moves->at.y, 0.2, 1e-12);
}

TEST(NozzleGesture, StaysWhereTheRayMissesItsPlane)
{
    const Vec3<double> eye{0.5, 1, 0.5};
    NozzleGesture g(rope, from_above(0.2, 0.5), {{0.2, 0, 0.5}, {0, 1, 0}}, {});
    EXPECT_FALSE(g.move({eye, {0, -1, 0}, {1, 0, 0}}));
    EXPECT_FALSE(g.move({eye, {0, -1, 0}, {1, 0.1, 0}}));
    EXPECT_FALSE(g.move({eye, {0, -1, 0}, {1, -0.01, 0}}));
    EXPECT_FALSE(g.move({eye, {0, -1, 0}, {std::nan(""), -1, 0}}));
    EXPECT_TRUE(g.move({eye, {0, -1, 0}, {0.1, -1, 0}}));
}

}  // namespace
}  // namespace knead
