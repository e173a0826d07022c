// Clay laid with mouse or hand: where it begins and goes, and its commands.
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

// In the air, as a hand leads it; with its own circle as the section.
TEST(NozzleGesture, FollowsAHandInTheAir)
{
    UiState ui;
    ui.document = std::make_shared<const Document>();
    ui.section = 2, ui.diameter = 0.1;
    NozzleTool tool = nozzle_tool(ui, 0.04);
    EXPECT_EQ(tool.section, SectionKind::star);
    EXPECT_EQ(tool.diameter, 0.1);
    NozzleGesture g(tool, {1, 2, 3}, {5, 0, 0});
    EXPECT_EQ(g.begin().at.x, 6);
    EXPECT_FALSE(g.move_to({1, 2, 3.009})) << "less than a tenth of the diameter";
    const auto move = g.move_to({1, 2, 3.02});
    ASSERT_TRUE(move);
    EXPECT_EQ(move->at.z, 3.02);
    ui.ring = true;
    tool = nozzle_tool(ui, 0.04);
    EXPECT_EQ(tool.section, SectionKind::circle);
    EXPECT_EQ(tool.diameter, 0.04);
    EXPECT_EQ(nozzle_tool(ui, 7.0).diameter, nozzle_range.high);
    EXPECT_EQ(nozzle_tool(ui).diameter, 0.1) << "a controller forms no ring";
}

// What a nozzle reports of its last move.
TEST(NozzleGesture, IsCloggedWhereItsLastMoveLaidNothing)
{
    const auto shared = std::make_shared<LiveState>();
    LiveState& state = *shared;
    SceneObject strand;
    strand.id = {4}, strand.name = "strand";
    Document document;
    document.objects.push_back(std::make_shared<const SceneObject>(strand));
    state.document = std::make_shared<const Document>(document);
    NozzleTool tool;
    tool.name = "strand";
    const NozzleGesture g(tool, {0, 0, 0}, {});
    EXPECT_FALSE(clogged(state, g));
    state.source = {{4}, 0, 70, true};
    EXPECT_TRUE(clogged(state, g));
    state.source.object = {3};
    EXPECT_FALSE(clogged(state, g)) << "of another one";
}

}  // namespace
}  // namespace knead
