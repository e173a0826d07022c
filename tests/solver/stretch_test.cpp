// Tools that a motion has larger or smaller are tools of a rig of that size, on every back end.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host/bench/ball.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/same_bits.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test

constexpr double frame = 1.0 / 90;
constexpr Stretch<float> sizes[2] = {{0.75f, 1.25f}, {1.5f, 0.5f}};

// The ball between tools that stand off their joints in all directions; some of clay may rest.
Given between_tools(bool stretched_rig)
{
    Given s = ball(32);
    add_tools(s);
    for (std::size_t i = 0; i < s.rig.spheres.size(); ++i) {
        Binding<float>& b = s.rig.spheres[i];
        b.offset[0].x += 0.02f, b.offset[0].z += i % 2 ? 0.06f : -0.03f;
        if (stretched_rig) b = stretched(b, sizes[i / 2]);
    }
    s.rest.mode = RestMode::sleep;
    return rounded_to_float(s);
}

Motion moving(int f, bool stretched_motion)
{
    Motion m = closing(f * frame, frame);
    if (stretched_motion) m.stretch.assign(sizes, sizes + 2);
    return m;
}

class Stretched : public AgainstTheReference {};
INSTANTIATE_TEST_SUITE_P(Solver, Stretched, ::testing::ValuesIn(back_ends),
                         [](const auto& at) { return std::string(at.param.name); });

TEST_P(Stretched, ToolsAreThoseOfARigOfTheirSize)
{
    if (GetParam().device && !GetParam().deterministic) return;  // sums come in any order
    const auto solver = GetParam().make(between_tools(false)),
               large = GetParam().make(between_tools(true));
    const auto usual = GetParam().make(between_tools(false));
    long projected = 0;
    for (int f = 0; f < 4; ++f) {
        projected += solver->advance(moving(f, true), frame)[Count::projected];
        large->advance(moving(f, false), frame), usual->advance(moving(f, false), frame);
    }
    EXPECT_GT(projected, 0);
    EXPECT_TRUE(same_bits(solver->particles(), large->particles()));
    EXPECT_FALSE(same_bits(solver->particles(), usual->particles()));
}

TEST_P(Stretched, ToolsMoveClayAsInTheReference)
{
    const Given s = between_tools(false);
    const auto solver = GetParam().make(s);
    Reference reference(s);
    for (int f = 0; f < 2; ++f)
        solver->advance(moving(f, true), frame), reference.advance(moving(f, true), frame);
    const auto a = solver->particles(), b = reference.particles();
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::fmax(most, length(a[i].x - b[i].x));
    EXPECT_LT(most, 5e-3 * s.lattice.dx);
}

TEST_P(Stretched, ToolsOfNoSizeAreRefused)
{
    const auto solver = GetParam().make(between_tools(false));
    for (const float bad : {0.0f, -1.0f, std::numeric_limits<float>::infinity(), std::nanf("")})
        for (const bool across : {false, true}) {
            Motion m = moving(0, true);
            (across ? m.stretch[1].across : m.stretch[1].along) = bad;
            EXPECT_THROW(solver->advance(m, frame), std::invalid_argument) << bad;
        }
    solver->advance(moving(0, true), frame);
}

}  // namespace
}  // namespace knead
