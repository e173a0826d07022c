// Clay that two tools hold between them is told from clay that one has not let out yet.
#include "host/solver/between.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/solver/audit.h"
#include "host/solver/editable_simulator.h"
#include "tests/sanitized.h"
#include "tests/solver/back_ends.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test

// Two spheres, each a tool on a joint of its own.
Given two_spheres(double radius)
{
    Given s;
    s.lattice = {{32, 32, 32}, 1.0 / 32};
    s.walls = walls_inside(s.lattice, 3, ContactMode::separate, 0);
    for (int t = 0; t < 2; ++t) {
        Binding<float> b{};
        for (int& j : b.joint) j = t;
        b.weight[0] = 1, b.radius = float(radius);
        s.rig.spheres.push_back(b);
        s.rig.primitives.push_back({1, {t, t, t}, t});
        s.tools.push_back({ContactMode::separate, 0.3, false, true});
    }
    return s;
}

Motion standing(Vec3<double> a, Vec3<double> b)
{
    const std::vector<Joint<double>> at{{{1, 0, 0, 0}, a}, {{1, 0, 0, 0}, b}};
    return {at, at, {1, 1}};
}

TEST(Between, IsWhatHasNoWayOutOfTwoTools)
{
    const Given s = two_spheres(0.2);
    const Motion overlap = standing({0.4, 0.5, 0.5}, {0.7, 0.5, 0.5});
    const auto depths = [&](const Motion& m, double x) {
        Particle<double> q{};
        q.x = {x, 0.5, 0.5};
        return depths_between(s, m, {q});
    };
    ASSERT_EQ(depths(overlap, 0.53).size(), 1u);  // on the side of the first, in both
    EXPECT_NEAR(depths(overlap, 0.53)[0], 0.07, 1e-7);
    ASSERT_EQ(depths(overlap, 0.48).size(), 1u);  // in the first alone, its way out in the other
    EXPECT_NEAR(depths(overlap, 0.48)[0], 0.12, 1e-7);
    EXPECT_TRUE(depths(overlap, 0.35).empty());  // out on the far side
    EXPECT_TRUE(depths(overlap, 0.95).empty());
    EXPECT_TRUE(depths(standing({0.25, 0.5, 0.5}, {0.75, 0.5, 0.5}), 0.4).empty());
    Motion lost = overlap;
    lost.active = {1, 0};
    EXPECT_TRUE(depths(lost, 0.53).empty());
    Motion small = overlap;
    small.size = {1, 0.25f};
    EXPECT_TRUE(depths(small, 0.53).empty());
}

// Two plates across the whole box, each a tool of two triangles on a joint of its own.
Given two_plates(double radius)
{
    Given s = two_spheres(radius);
    s.rig = {};
    for (int t = 0; t < 2; ++t) {
        const int first = 4 * t;
        for (const float y : {-1.0f, 1.0f})
            for (const float z : {-1.0f, 1.0f}) {
                Binding<float> b{};
                for (int& j : b.joint) j = t;
                b.weight[0] = 1, b.radius = float(radius), b.offset[0] = {0, y, z};
                s.rig.spheres.push_back(b);
            }
        s.rig.primitives.push_back({3, {first, first + 1, first + 2}, t});
        s.rig.primitives.push_back({3, {first + 1, first + 2, first + 3}, t});
    }
    return s;
}

// A liquid between two plates that go into each other has nowhere to be. What it is pressed by its
// strain knows, and it stands it: a liquid that stiffens by J^-7 without end threw itself out at
// 1e8 m/s, in substeps of 1e-11 s.
// Some of its particles are crowded at a time. How many scatters with the length of substeps: at
// sixteen from 0.6 to 0.9 it is 0.7 to 3.9 %, and at worst 1.4 to 1.8 lie in the room of one.
void press_liquid(double courant)
{
    Given s = two_plates(0.05);
    s.step.courant = courant;
    s.lattice = {{32, 32, 12}, s.lattice.dx};  // a slice
    s.walls = walls_inside(s.lattice, 3, ContactMode::separate, 0);
    s.gravity = {0, -9.81, 0};
    const double dx = s.lattice.dx, h = dx / 2;
    Material<double> liquid{};
    liquid.plasticity = Plasticity::fluid, liquid.density = 1000;
    liquid.bulk = 1e5, liquid.exponent = 7, liquid.viscosity = 0.1;
    liquid.volume = h * h * h, liquid.mass = liquid.density * liquid.volume;
    s.materials = {liquid};
    const double floor = s.walls.min.y;
    for (double x = s.walls.min.x + h / 2; x < s.walls.max.x; x += h)
        for (double y = floor + h / 2; y < floor + 0.35; y += h)
            for (double z = s.walls.min.z + h / 2; z < s.walls.max.z; z += h) {
                Particle<double> q{};
                q.x = {x, y, z};
                s.particles.push_back(q);
            }
    const auto solver = cpu_solver(s);
    const auto side = [&](double apart) {
        return standing({0.5 - apart, floor + 0.18, 0.5}, {0.5 + apart, floor + 0.18, 0.5});
    };
    Motion last;
    int most_substeps = 0;
    double depth = 0;
    std::size_t most = 0;
    Crowding worst;
    for (int f = 0; f < 20; ++f) {
        const double now = 0.2 - 0.008 * f, then = 0.2 - 0.008 * (f + 1);
        last = side(now), last.to = side(then).to;
        most_substeps = std::max(most_substeps, solver->advance(last, 1.0 / 90).substeps);
        const auto clay = solver->particles();
        const std::vector<double> held = depths_between(s, last, clay);
        for (const double d : held) depth = std::fmax(depth, d);
        most = std::max(most, held.size());
        const Crowding now_crowded = crowding(clay, s.materials, dx);
        if (now_crowded.particles > worst.particles) worst = now_crowded;
    }
    const Audit before = audit(s.particles, s.materials, dx);
    const Audit after = audit(solver->particles(), s.materials, dx);
    if (std::getenv("KNEAD_SHOW"))
        std::printf(
            "between %zu, %.3g cells; crowded %ld, %.3g times; volume %.3g; %d substeps, %g m/s\n",
            most, depth / dx, worst.particles, worst.most, after.volume / before.volume,
            most_substeps, after.fastest);
    EXPECT_GT(most, 500u);
    EXPECT_GT(depth, 0.1 * dx);
    EXPECT_LT(after.volume, 0.8 * before.volume);
    EXPECT_LT(after.fastest, 100);
    EXPECT_LT(most_substeps, 85 / courant);
    EXPECT_LT(worst.most, 2);
    EXPECT_LT(worst.particles, long(s.particles.size() / 20));
}

TEST(Between, ALiquidUnderCrossedToolsIsPressedAndReportedAndStandsIt)
{
    press_liquid(0.7);
    if (sanitized) return;
    press_liquid(0.8);
    press_liquid(0.85);
}

}  // namespace
}  // namespace knead
