// How long a substep may be.
#include "cuda/mpm/time_step.h"

#include <gtest/gtest.h>

#include <random>

#include "host/solver/substep.h"
#include "tests/solver/clay.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test

TEST(StepLimits, IsThatOfTheStiffestAndTheMostViscousMaterial)
{
    Given s;
    s.lattice = {{16, 16, 16}, 0.01};
    Material<double> soft{}, stiff{}, thick{};
    soft.density = stiff.density = thick.density = 1000;
    soft.mu = 1e3, stiff.mu = 4e5, stiff.lambda = 1e5;
    thick.plasticity = Plasticity::fluid, thick.bulk = 1e4, thick.viscosity = 50;
    s.materials = {soft, stiff, thick};
    const StepLimits p = step_limits(s);
    EXPECT_DOUBLE_EQ(p.stiffness, (3 * 1e5 + 2 * 4e5) / 1e3);
    EXPECT_DOUBLE_EQ(p.viscosity, s.step.courant * 1e-4 * 1000 / 4 / 50);
    EXPECT_DOUBLE_EQ(p.dx, 0.01);
}

// The tangent, by differences of the stress along each principal axis and their sum, is never
// steeper than stiffness() says, and hardly less steep where the strain is a pure volume change.
TEST(StepLimits, StiffnessBoundsTheTangentOfTheStress)
{
    std::mt19937 source(7);
    std::uniform_real_distribution<> strain(-0.4, 0.4), packed(-0.3, 0.05);
    for (const Plasticity plasticity : {Plasticity::none, Plasticity::clamp, Plasticity::fluid})
        for (const Elasticity elasticity : elasticities)
            for (int k = 0; k < 300; ++k) {
                Material<double> m{};
                m.elasticity = elasticity, m.plasticity = plasticity, m.density = 800;
                m.mu = 3e5, m.lambda = 5e5, m.bulk = 6e5, m.exponent = 7, m.snow = 10;
                const bool even = k % 3 == 0;
                const double a = strain(source);
                const Vec3<double> eps{a, even ? a : strain(source), even ? a : strain(source)};
                const auto at = [&](Vec3<double> e) {
                    Particle<double> q{};
                    q.e = {std::expm1(2 * e.x), std::expm1(2 * e.y), std::expm1(2 * e.z), 0, 0, 0};
                    q.k = plasticity == Plasticity::clamp ? -0.1 : 0;
                    return q;
                };
                constexpr double h = 1e-6;
                const auto stress = [&](Vec3<double> e) { return kirchhoff_stress(at(e), m); };
                const Vec3<double> all{h, h, h};
                const double bulk = (trace(stress(eps + all)) - trace(stress(eps - all))) / (6 * h);
                const Vec3<double> one{h, 0, 0};
                const double along = (stress(eps + one).xx - stress(eps - one).xx) / (2 * h);
                const double bound = stiffness(at(eps), m) * m.density;
                EXPECT_GE(bound * (1 + 1e-6), bulk);
                EXPECT_GE(bound * (1 + 1e-6), along);
                if (even && a >= 0) {
                    EXPECT_LE(bound, 1.35 * bulk);
                }
            }
}

TEST(StepLimits, WhatIsStifferThanAtRestShortensTheStepButNotForEver)
{
    const StepLimits p{0.8, 0.02, 100, 1e30, 0, 1e-2};
    const auto dt = [&](double stiffness) { return choose_dt(p, {0, stiffness}, 1e30, 1e30).dt; };
    const double rest = 0.8 * 0.02 / 10, rounding = 2e-9 * rest;
    EXPECT_NEAR(dt(0), rest, rounding);
    EXPECT_NEAR(dt(400), rest / 2, rounding);
    EXPECT_NEAR(dt(1e30), rest / std::sqrt(most_stiffening), rounding);
    EXPECT_NEAR(dt(NAN), rest, rounding);
}

TEST(StepLimits, NoLimitIsPassedAndTheTightestIsNamed)
{
    std::mt19937 source(3);
    const auto draw = [&](double low, double high) {
        return std::exp(std::uniform_real_distribution<>(std::log(low), std::log(high))(source));
    };
    int seen[int(Limit::count)] = {};
    for (int k = 0; k < 20000; ++k) {
        const StepLimits p{0.8, 0.02, draw(0.1, 1e4), draw(1e-5, 1), 0, 1e-2};
        const double stiffness = draw(0.1, 1e4);
        const double speed = draw(1e-3, 1e3), tool = draw(1e-5, 1), left = draw(1e-5, 1e-1);
        const double most = most_stiffening * p.stiffness;
        const double wave = 0.8 * 0.02 / std::sqrt(std::clamp(stiffness, p.stiffness, most));
        const StepChoice c = choose_dt(p, {speed, stiffness}, tool, left);
        const double bounds[] = {wave, 0.5 * 0.02 / speed, tool, p.viscosity, 1e30, left};
        ASSERT_LE(c.dt, bounds[int(c.limit)]);
        for (double bound : bounds) ASSERT_LE(c.dt, bound);
        ASSERT_LE(c.dt, p.largest);
        if (c.limit != Limit::frame_end) {
            // What remains is a whole number of such steps, none needlessly short.
            const double steps = left / c.dt, nearest = std::round(steps);
            ASSERT_NEAR(steps, nearest, 1e-9 * nearest);
            ASSERT_GT(left / (nearest - 1), c.dt * (1 - 1e-9));
        }
        ++seen[int(c.limit)];
    }
    for (const Limit l :
         {Limit::sound, Limit::speed, Limit::tool, Limit::viscosity, Limit::frame_end})
        EXPECT_GT(seen[int(l)], 0) << limit_names[int(l)];
}

TEST(StepLimits, AFixedStepIsKeptWhateverElse)
{
    const StepLimits p{0.4, 0.02, 10, 1e-6, 3e-4, 1e-2};
    EXPECT_EQ(choose_dt(p, {1e3, 0}, 1e-7, 1).dt, 3e-4);
    EXPECT_EQ(choose_dt(p, {1e3, 0}, 1e-7, 1).limit, Limit::fixed);
    EXPECT_EQ(choose_dt(p, {1e3, 0}, 1e-7, 1e-4).dt, 1e-4);
    EXPECT_EQ(choose_dt(p, {1e3, 0}, 1e-7, 1e-4).limit, Limit::frame_end);
}

// Each substep is the one that the speeds at the beginning of the one before ask for, and together
// they fill the frame.
TEST(Step, FollowEachOtherToTheEndOfTheFrame)
{
    const StepLimits p{0.8, 0.02, 100, 1e30, 0, 1e-2};
    std::mt19937 source(5);
    std::uniform_real_distribution<> any_speed(0, 40), any_duration(1e-4, 2e-2);
    for (int k = 0; k < 200; ++k) {
        const double duration = any_duration(source);
        double sum = 0;
        Extremes speed{any_speed(source), 0};
        Step s = step_at(p, 0, speed, 1e30, duration);
        ASSERT_EQ(s.dt, choose_dt(p, speed, 1e30, duration).dt);
        while (s.dt > 0) {
            ASSERT_DOUBLE_EQ(s.start, sum);
            ASSERT_LE(s.dt, p.courant * p.dx / std::sqrt(p.stiffness) * (1 + 1e-9));
            const Step next = step_after(s, p, speed, 1e30, duration);
            sum += s.dt;
            if (duration - sum > 1e-9 * duration) {
                ASSERT_NEAR(next.dt, choose_dt(p, speed, 1e30, duration - sum).dt, 1e-12);
            }
            s = next;
            speed.speed = any_speed(source);
        }
        EXPECT_NEAR(sum, duration, 1e-12 * duration);
        EXPECT_EQ(step_after(s, p, speed, 1e30, duration).dt, 0);
    }
}

}  // namespace
}  // namespace knead
