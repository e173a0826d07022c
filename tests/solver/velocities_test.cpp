// What clay moves with under a tool, beside the speed at which particles leave it (19).
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "host/solver/audit.h"
#include "tests/mpm/resting.h"
#include "tests/solver/back_ends.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
using resting::at;
using resting::dx;
using resting::frame;

// A block of clay on a floor, and a ball of 4 cells' radius above its middle.
Given block_under_ball()
{
    Given s = resting::scene({24, 24, 24}, 2e4);
    s.rest.mode = RestMode::none;
    s.gravity = {0, -9.81, 0}, s.step.courant = 0.97;
    resting::add(s, {6, 3, 6}, {18, 12, 18});
    resting::add_ball(s, 4 * dx);
    return rounded_to_float(s);
}
Vec3<double> above(double height) { return {12 * dx, height, 12 * dx}; }

using Velocities = AgainstTheReference;
INSTANTIATE_TEST_SUITE_P(Solver, Velocities, ::testing::ValuesIn(back_ends),
                         [](const auto& at) { return std::string(at.param.name); });

TEST_P(Velocities, ClayAtRestUnderABallIsSaidToBeAtRest)
{
    const Given s = block_under_ball();
    const auto solver = GetParam().make(s);
    EXPECT_TRUE(solver->velocities().empty());
    const double top = 12 * dx + 4 * dx;
    for (int f = 0; f < 20; ++f)
        solver->advance(at(above(top - 0.1 * dx * f), above(top - 0.1 * dx * (f + 1))), frame);
    for (int f = 0; f < 40; ++f)
        solver->advance(at(above(top - 2 * dx), above(top - 2 * dx)), frame);
    const auto all = solver->particles();
    const auto moved = solver->velocities();
    ASSERT_EQ(moved.size(), all.size());
    const Audit own = audit(all, s.materials, dx), clay = audit(all, s.materials, dx, moved);
    std::printf("particles %.3g J, %.3g m/s; clay %.3g J, %.3g m/s\n", own.kinetic, own.fastest,
                clay.kinetic, clay.fastest);
    EXPECT_GT(own.fastest, 1);  // what leaves the ball is thrown
    EXPECT_LT(clay.fastest, 0.1 * own.fastest);
    EXPECT_LT(clay.kinetic, 0.02 * own.kinetic);
    std::size_t others = 0;
    for (std::size_t i = 0; i < all.size(); ++i) others += length(all[i].v - moved[i]) == 0;
    EXPECT_GT(others, all.size() / 2);  // who is in no tool has its own
    solver->advance(
        [&] {
            Motion m = at(above(top), above(top));
            m.active = {false};
            return m;
        }(),
        frame);
    const auto later = solver->velocities();
    if (later.empty()) return;
    const auto free = solver->particles();
    for (std::size_t i = 0; i < later.size(); ++i) ASSERT_EQ(length(free[i].v - later[i]), 0);
}

// Clay that a ball drives before it moves as fast as the ball, on every back end as in the
// reference.
TEST_P(Velocities, ClayThatIsDrivenMovesAsInTheReference)
{
    const Given s = block_under_ball();
    const auto solver = GetParam().make(s);
    Reference reference(s);
    const double top = 12 * dx + 4 * dx, speed = 1;
    for (int f = 0; f < 4; ++f) {  // later rounding grows: contact throws crumbs about
        const Motion m = at(above(top - speed * frame * f), above(top - speed * frame * (f + 1)));
        solver->advance(m, frame), reference.advance(m, frame);
    }
    const Audit mine = audit(solver->particles(), s.materials, dx, solver->velocities());
    const auto q = reference.particles();
    const Audit wanted = audit(q, s.materials, dx, reference.velocities());
    const Audit thrown = audit(q, s.materials, dx);
    std::printf("%.4g J, %.4g m/s; reference %.4g J, %.4g m/s; with what is thrown %.4g J, %.4g\n",
                mine.kinetic, mine.fastest, wanted.kinetic, wanted.fastest, thrown.kinetic,
                thrown.fastest);
    EXPECT_NEAR(mine.kinetic, wanted.kinetic, 0.01 * wanted.kinetic);
    EXPECT_NEAR(mine.fastest, wanted.fastest, 0.02 * wanted.fastest);
    EXPECT_GT(mine.fastest, 0.8 * speed);
    EXPECT_LT(mine.fastest, 1.6 * speed);
    EXPECT_GT(thrown.fastest, 2 * wanted.fastest);
}

}  // namespace
}  // namespace knead
