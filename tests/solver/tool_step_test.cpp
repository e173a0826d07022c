// How long a substep may be for the tools.
#include <gtest/gtest.h>

#include <cmath>

#include "host/bench/ball.h"
#include "host/solver/substep.h"

namespace knead {
namespace {

// Of two tools that hang on one joint, the second three times as long as the rig.
TEST(ToolStep, IsThatOfTheSphereThatMovesFarthestForItsSize)
{
    constexpr double angle = 0.1, frame = 1.0 / 90;
    auto s = ball(16);
    s.rig = {}, s.tools.assign(2, {ContactMode::separate, 0.2, false, true});
    Binding<float> far{};
    far.weight[0] = 1, far.offset[0] = {0, 0, 0.125f}, far.radius = 0.03125f;
    Binding<float> wide = far;
    wide.radius = 0.5f;  // more than a cell, which counts then
    s.rig.spheres = {far, wide};
    s.rig.primitives = {{2, {0, 1, 1}, 0}, {2, {1, 0, 0}, 1}, {1, {0, 0, 0}, 0}, {1, {0, 0, 0}, 1}};
    const Joint<double> before{{1, 0, 0, 0}, {0.5, 0.5, 0.5}};
    const Joint<double> after{turn_about(Vec3<double>{1, 0, 0}, angle), before.p};
    Motion motion{{before}, {after}, {1, 1}};
    motion.stretch = {{1, 1}, {1, 3}};
    const double way = 2 * 0.125 * std::sin(angle / 2);
    const double shorter = s.step.tool * 0.03125 / (3 * way) * frame;
    EXPECT_NEAR(tool_step(s, motion, frame), shorter, 1e-12 * shorter);
    motion.active = {1, 0};
    EXPECT_NEAR(tool_step(s, motion, frame), 3 * shorter, 3e-12 * shorter);
    s.rig.primitives = {{1, {1, 1, 1}, 0}};
    const double of_a_cell = s.step.tool * s.lattice.dx / way * frame;
    EXPECT_NEAR(tool_step(s, motion, frame), of_a_cell, 1e-12 * of_a_cell);
    motion.active = {0, 0};
    EXPECT_EQ(tool_step(s, motion, frame), 1e30);
}

}  // namespace
}  // namespace knead
