// Clay outside of the boxes of the localized mode: it stays, and what moves makes way around it.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "host/solver/audit.h"
#include "tests/mpm/resting.h"

namespace knead {
namespace {

using namespace resting;
using resting::Given;  // not that of scenes

class Localized : public Resting {};
INSTANTIATE_TEST_SUITE_P(Solver, Localized, testing::ValuesIn(backends),
                         [](const auto& at) { return std::string(at.param.name); });

TEST_P(Localized, ClayMovesInTheBoxesAndNowhereElse)
{
    Pressed slab;
    Given& s = slab.s;
    s.rest.mode = RestMode::localized, s.rest.reach = 8 * dx;
    s.step.fixed = 2.2e-4;   // or what flies would give the two runs substeps of their own
    s.deterministic = true;  // contact multiplies what sums in another order round
    add(s, {19, 15, 8}, {21, 17, 10}, {12, 0, 0});  // flies out of the box, in the first frame into
    add(s, {25, 15, 8}, {28, 17, 10});              // the block of these
    const auto held = make(s), other = awake_throughout(s);
    const FrameStats some = slab.press(*held, 1.5 * dx, 20), all = slab.press(*other, 1.5 * dx, 20);
    EXPECT_GT(some[Count::moved], all[Count::moved] / 8);
    EXPECT_LT(some[Count::moved], all[Count::moved] / 2);
    EXPECT_EQ(some[Count::woken], 0);
    const Particles a = held->particles(), b = other->particles();
    const double box = 10 * dx + slab.radius + s.rest.reach;
    Particles inside[2];
    double pressed = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        const Particle<double>& p = s.particles[i];
        pressed = std::fmax(pressed, p.x.y - a[i].x.y);
        if (p.x.x > box + 4 * dx) {
            ASSERT_EQ(length(a[i].x - p.x) + length(a[i].v), 0) << i;
        }
        if (p.x.x < 10 * dx + slab.radius + 2 * dx)
            inside[0].push_back(a[i]), inside[1].push_back(b[i]);
    }
    EXPECT_GT(pressed, dx);
    EXPECT_LT(apart(inside[0], inside[1]).mean, 1e-3);
    EXPECT_LT(apart(inside[0], inside[1]).max, 5e-3);
}

// A ball goes 4 cells down into the middle of a slab of 9, of which what is held begins 1 to 4
// cells below it: clay makes way to the sides, not into what is held.
TEST_P(Localized, ClayMakesWayAroundWhatIsHeldNotIntoIt)
{
    Given s = scene({32, 24, 32}, 2e4);
    s.gravity = {0, -9.81, 0}, s.rest.mode = RestMode::localized, s.rest.reach = dx;
    add(s, {6, 3, 6}, {26, 12, 26});
    add_ball(s, 3 * dx);
    const auto held = make(s), other = awake_throughout(s);
    const auto place = [](int f) { return Vec3<double>{0.5, (15.1 - 0.2 * f) * dx, 0.5}; };
    for (int f = 0; f < 20; ++f)
        for (EditableSimulator* one : {held.get(), other.get()})
            one->advance(at(place(f), place(f + 1)), frame);
    const Particles a = held->particles(), b = other->particles();
    const Crowding within = crowding(a, s.materials, dx);
    std::printf("crowded %ld of %zu, at most %.3g; apart %.3g, at most %.3g cells\n",
                within.particles, a.size(), within.most, apart(a, b).mean, apart(a, b).max);
    EXPECT_EQ(within.particles, 0);
    EXPECT_LT(within.most, 1.15);
    long still = 0;
    for (std::size_t i = 0; i < a.size(); ++i) still += length(a[i].x - s.particles[i].x) == 0;
    EXPECT_GT(still, long(a.size() / 4));
}

}  // namespace
}  // namespace knead
