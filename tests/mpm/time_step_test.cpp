// How long a substep may be.
#include "cuda/mpm/time_step.h"

#include <gtest/gtest.h>

#include <random>

#include "host/solver/substep.h"

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
    EXPECT_DOUBLE_EQ(p.sound, 30);  // sqrt(9e5 / 1e3)
    EXPECT_DOUBLE_EQ(p.viscosity, 1e-4 * 1000 / 6 / 50);
    EXPECT_DOUBLE_EQ(p.dx, 0.01);
    stiff.plasticity = Plasticity::clamp, stiff.snow = 10;
    s.materials = {soft, stiff, thick};
    EXPECT_GT(step_limits(s).sound, 30) << "packed snow is stiffer";
}

TEST(StepLimits, NoLimitIsPassedAndTheTightestIsNamed)
{
    std::mt19937 source(3);
    const auto draw = [&](double low, double high) {
        return std::exp(std::uniform_real_distribution<>(std::log(low), std::log(high))(source));
    };
    int seen[int(Limit::count)] = {};
    for (int k = 0; k < 20000; ++k) {
        const StepLimits p{0.4, 0.02, draw(0.1, 100), draw(1e-5, 1), 0, 1e-2};
        const double speed = draw(1e-3, 1e3), tool = draw(1e-5, 1), left = draw(1e-5, 1e-1);
        const double wave = p.courant * p.dx / (p.sound + speed);
        const StepChoice c = choose_dt(p, speed, tool, left);
        const double bounds[] = {wave, wave, tool, p.viscosity, 1e30, left};
        ASSERT_LE(c.dt, bounds[int(c.limit)]);
        for (double bound : bounds) ASSERT_LE(c.dt, bound);
        ASSERT_LE(c.dt, p.largest);
        if (c.limit != Limit::frame_end) {
            // What remains is a whole number of such steps, none needlessly short.
            const double steps = left / c.dt, nearest = std::round(steps);
            ASSERT_NEAR(steps, nearest, 1e-9 * nearest);
            ASSERT_GT(left / (nearest - 1), c.dt * (1 - 1e-9));
            if (c.limit == Limit::sound) {
                ASSERT_GT(p.sound, speed);
            }
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
    EXPECT_EQ(choose_dt(p, 1e3, 1e-7, 1).dt, 3e-4);
    EXPECT_EQ(choose_dt(p, 1e3, 1e-7, 1).limit, Limit::fixed);
    EXPECT_EQ(choose_dt(p, 1e3, 1e-7, 1e-4).dt, 1e-4);
    EXPECT_EQ(choose_dt(p, 1e3, 1e-7, 1e-4).limit, Limit::frame_end);
}

// Each substep is the one that the speeds at the beginning of the one before ask for, and together
// they fill the frame.
TEST(Step, FollowEachOtherToTheEndOfTheFrame)
{
    const StepLimits p{0.4, 0.02, 10, 1e30, 0, 1e-2};
    std::mt19937 source(5);
    std::uniform_real_distribution<> any_speed(0, 40), any_duration(1e-4, 2e-2);
    for (int k = 0; k < 200; ++k) {
        const double duration = any_duration(source);
        double sum = 0, speed = any_speed(source);
        Step s = step_at(p, 0, speed, 1e30, duration);
        ASSERT_EQ(s.dt, choose_dt(p, speed, 1e30, duration).dt);
        while (s.dt > 0) {
            ASSERT_DOUBLE_EQ(s.start, sum);
            ASSERT_LE(s.dt, p.courant * p.dx / p.sound * (1 + 1e-9));
            const Step next = step_after(s, p, speed, 1e30, duration);
            sum += s.dt;
            if (duration - sum > 1e-9 * duration) {
                ASSERT_NEAR(next.dt, choose_dt(p, speed, 1e30, duration - sum).dt, 1e-12);
            }
            s = next;
            speed = any_speed(source);
        }
        EXPECT_NEAR(sum, duration, 1e-12 * duration);
        EXPECT_EQ(step_after(s, p, speed, 1e30, duration).dt, 0);
    }
}

}  // namespace
}  // namespace knead
