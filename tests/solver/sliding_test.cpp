// Clay that slides along a wall, as all back ends have it: on a slope it stays where friction can
// hold it, and how it slides is part of a solver's state.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/scene/presets.h"
#include "host/verify/clay.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/same_bits.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test
using Particles = std::vector<Particle<double>>;

constexpr double g = 9.81;

// A block, 8 x 4 x 8 cm, on the floor of a box 32 cm long.
Given block(const std::string& material, int cells_high, double friction)
{
    const double dx = 0.04 / cells_high;
    Given s = between_walls({8 * cells_high, 2 * cells_high, 3 * cells_high}, dx,
                            ContactMode::separate, friction);
    s.gravity = {0, -g, 0};
    Material<double> m = preset(material);
    const Vec3<double> corner = s.walls.min + Vec3<double>{0.02, 0, 0.02};
    fill(s, m, corner, corner + Vec3<double>{0.08, 0.04, 0.08}, 2);
    return s;
}

Vec3<double> middle(const Simulator& solver)
{
    const Particles all = solver.particles();
    Vec3<double> sum{};
    for (const auto& q : all) sum = sum + q.x;
    return (1.0 / double(all.size())) * sum;
}

class Slides : public AgainstTheReference {};
INSTANTIATE_TEST_SUITE_P(Solver, Slides, ::testing::ValuesIn(back_ends),
                         [](const auto& at) { return std::string(at.param.name); });

// Put there all at once, with a tenth of friction to spare, it springs down, and stays. It slid 10
// mm in the first third of a second, and on, where friction followed its pressure at once.
TEST_P(Slides, ABlockOnASlopeStays)
{
    for (const int cells : {4, 6}) {
        const double angle = 20 * std::numbers::pi / 180;
        Given s = block("clay", cells, std::tan(angle) / 0.91);
        s.gravity = {g * std::sin(angle), -g * std::cos(angle), 0};
        const auto solver = GetParam().make(s);
        const Vec3<double> start = middle(*solver);
        for (int f = 0; f < 12; ++f) solver->advance({}, 1.0 / 60);
        const Vec3<double> then = middle(*solver);
        EXPECT_LT(length(then - start), 0.3e-3) << cells;
        for (int f = 0; f < 12; ++f) solver->advance({}, 1.0 / 60);
        EXPECT_LT(length(middle(*solver) - then), 0.02e-3) << cells;
    }
}

// Beyond what friction can hold it slides, as fast as what is left of its weight makes it.
TEST_P(Slides, ABlockOnASteeperSlopeDoesNot)
{
    const double angle = 25 * std::numbers::pi / 180, friction = 0.3;
    Given s = block("clay", 4, friction);
    s.gravity = {g * std::sin(angle), -g * std::cos(angle), 0};
    const auto solver = GetParam().make(s);
    const Vec3<double> start = middle(*solver);
    const double time = 0.3;
    for (int f = 0; f < 18; ++f) solver->advance({}, time / 18);
    const double way = g * (std::sin(angle) - friction * std::cos(angle)) * time * time / 2;
    EXPECT_NEAR(middle(*solver).x - start.x, way, 0.04 * way);
}

// On a flat floor it loses what friction takes, however many nodes it passes. It lost a tenth less
// on the finer cells where a node that lifted forgot what it owed.
TEST_P(Slides, ABlockThatIsPushedLosesWhatFrictionTakes)
{
    for (const int cells : {4, 8}) {
        Given s = block("clay", cells, 0.3);
        Material<double>& m = s.materials[0];
        const Material<double> soft = elastic(3e5, 0.3, 1000);
        const double volume = m.volume;
        m = soft, m.volume = volume, m.mass = soft.density * volume;
        const auto solver = GetParam().make(s);
        for (int f = 0; f < 10; ++f) solver->advance({}, 0.015);
        SavedState pushed = solver->save();
        for (auto& q : pushed.contents.particles) q.v.x += 1;
        pushed.speed_squared = 2;
        solver->load(pushed);
        const auto speed = [&] {
            double sum = 0;
            for (const auto& q : solver->particles()) sum += q.v.x;
            return sum / double(solver->particle_count());
        };
        for (int f = 0; f < 5; ++f) solver->advance({}, 0.01);
        const double before = speed();
        for (int f = 0; f < 10; ++f) solver->advance({}, 0.01);
        EXPECT_NEAR((before - speed()) / 0.1, 0.3 * g, 0.04 * 0.3 * g) << cells;
    }
}

TEST_P(Slides, AsTheReferenceHasIt)
{
    Given s = rounded_to_float(block("soft-clay", 4, 0.4));
    for (auto& q : s.particles) q.v.x = 0.5;
    const auto mine = GetParam().make(s);
    Reference reference(s);
    for (int f = 0; f < 4; ++f) mine->advance({}, 0.01), reference.advance({}, 0.01);
    const Particles one = mine->particles(), other = reference.particles();
    double worst = 0;
    for (std::size_t i = 0; i < one.size(); ++i)
        worst = std::fmax(worst, length(one[i].x - other[i].x));
    EXPECT_LT(worst, 2e-6);
    EXPECT_GT(middle(*mine).x, middle(*GetParam().make(s)).x + 0.015);
}

// Between two frames of a slide: a state goes on to the bit, with how its clay slides; without that
// it does not.
TEST_P(Slides, AndGoesOnFromASavedStateAndASnapshot)
{
    Given s = block("clay", 4, 0.4);
    for (auto& q : s.particles) q.v = {0.3, 0, 0.1};
    s.threads = 2;
    if (GetParam().device && !GetParam().deterministic) GTEST_SKIP() << "sums in any order";
    const auto solver = GetParam().make(s);
    const auto play = [](Simulator& of) {
        for (int f = 0; f < 3; ++f) of.advance({}, 0.005);
        return of.particles();
    };
    play(*solver);
    const auto snapshot = solver->snapshot();
    const SavedState state = solver->save();
    EXPECT_GT(state.sliding.size(), 50u);
    for (const SlidingNode& n : state.sliding) EXPECT_GT(n.force, 0);
    const Particles first = play(*solver);
    solver->restore(*snapshot);
    EXPECT_EQ(solver->save().sliding.size(), state.sliding.size());
    EXPECT_TRUE(same_bits(play(*solver), first));

    const auto other = GetParam().make(s);
    other->advance({}, 0.001);
    other->load(state);
    EXPECT_TRUE(same_bits(play(*other), first));
    SavedState forgetful = state;
    forgetful.sliding.clear();
    other->load(forgetful);
    EXPECT_FALSE(same_bits(play(*other), first));

    // An edit is felt as a new scene is: sliding begins anew.
    solver->restore(*snapshot);
    Given now{solver->config(), {solver->particles(), {}}, s};
    now.gravity.y = -8, solver->set_gravity(now.gravity);
    EXPECT_TRUE(solver->save().sliding.empty());
    const auto fresh = GetParam().make(now);
    EXPECT_TRUE(same_bits(play(*solver), play(*fresh)));
}

// Nobody holds a blade any more, but the clay that was cut slides on, also in a simulator that has
// not seen a cut.
TEST_P(Slides, AndGoesOnWhereItWasCut)
{
    if (GetParam().device && !GetParam().deterministic) GTEST_SKIP() << "sums in any order";
    Given s = block("clay", 4, 0.4);
    s.threads = 2;
    const Given uncut = s;
    const double middle = s.walls.min.x + 0.06;
    for (auto& q : s.particles) q.v = {0.3, 0, 0.1}, q.sides = q.x.x < middle ? above : below;
    const auto solver = GetParam().make(s);
    EXPECT_TRUE(solver->config().cuts);
    const auto play = [](Simulator& of) {
        for (int f = 0; f < 3; ++f) of.advance({}, 0.005);
        return of.particles();
    };
    play(*solver);
    const SavedState state = solver->save();
    const int places = sliding_places(s.lattice.size, s.walls);
    EXPECT_GT(
        std::ranges::count_if(state.sliding, [&](const auto& n) { return n.place >= places; }), 10);
    const Particles first = play(*solver);

    const auto other = GetParam().make(uncut);
    EXPECT_FALSE(other->config().cuts);
    SavedState opened = state;
    opened.config = other->config();
    other->load(opened);
    EXPECT_TRUE(other->config().cuts);
    EXPECT_TRUE(same_bits(play(*other), first));

    // All its labels have faded, but not what it slid in their fields.
    for (auto& q : opened.contents.particles) q.sides = 0;
    const auto third = GetParam().make(uncut);
    third->load(opened);
    EXPECT_TRUE(third->config().cuts);
}

TEST_P(Slides, NoStateSlidesWhereNoneCan)
{
    Given s = block("clay", 4, 0.4);
    const auto solver = GetParam().make(s);
    const SavedState state = solver->save();
    const int places = sliding_places(s.lattice.size, s.walls);
    const float nan = std::nanf("");
    for (const SlidingNode& bad : std::vector<SlidingNode>{{-1, 1, 0.01f, 0},
                                                           {3 * places, 1, 0.01f, 0},
                                                           {0, -1, 0.01f, 0},
                                                           {0, nan, 0.01f, 0},
                                                           {0, 1, 0, 0},
                                                           {0, 1, INFINITY, 0},
                                                           {0, 1, nan, 0},
                                                           {0, 1, 0.01f, nan},
                                                           {0, 1, 0.01f, -INFINITY}}) {
        SavedState with = state;
        with.sliding = {bad};
        EXPECT_THROW(solver->load(with), std::invalid_argument) << bad.place;
    }
    SavedState with = state;
    with.sliding = {{places - 1, 1, 0.01f, -1}};
    solver->load(with);
    with.config.walls.mode = ContactMode::sticky;
    EXPECT_THROW(solver->load(with), std::invalid_argument);
}

}  // namespace
}  // namespace knead
