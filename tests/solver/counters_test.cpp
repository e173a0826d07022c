// What the counters of a GPU say, where they can be read.
#include "host/solver/counters.h"

#include <gtest/gtest.h>

#include "host/bench/ball.h"
#include "host/solver/editable_simulator.h"
#include "host/surface/gpu_surface.h"
#include "tests/solver/same_bits.h"
#include "tests/surface/surface_clay.h"

namespace knead {
namespace {

TEST(Counters, SayWhyNothingCanBeCounted)
{
    if (gpu_present()) GTEST_SKIP() << "there is a GPU";
    try {
        counted([](const StageObserver&) { FAIL() << "nothing may run"; });
        FAIL() << "nothing can have been counted";
    } catch (const std::runtime_error& e) {
        EXPECT_TRUE(std::string(e.what()).starts_with("counters: ")) << e.what();
    }
}

TEST(Counters, WorkAddsUp)
{
    DeviceWork sum{1, 2, 3, 4, 5};
    sum += 2 * DeviceWork{10, 20, 30, 40, 50};
    EXPECT_EQ(sum.instructions, 21);
    EXPECT_EQ(sum.memory_bytes, 42);
    EXPECT_EQ(sum.cache_bytes, 63);
    EXPECT_EQ(sum.cycles, 84);
    EXPECT_EQ(sum.seconds, 105);
    EXPECT_DOUBLE_EQ(sum.clock(), 0.8);
    EXPECT_EQ(DeviceWork{}.clock(), 0);
}

// Counters belong to root on many machines.
class GpuCounters : public testing::Test {
  protected:
    void SetUp() override
    {
        if (!gpu_present()) GTEST_SKIP() << "no GPU";
    }
    template <class Of>
    static std::vector<StageWork> counts_of(Of& of, std::string& why)
    {
        try {
            if constexpr (requires { of.profile(); })
                return of.profile()->counts();
            else
                return of.stage_counts();
        } catch (const std::runtime_error& e) {
            why = e.what();
            return {};
        }
    }
};

TEST_F(GpuCounters, CountTheStagesOfAFrameAndLeaveTheNextOnesAsTheyWere)
{
    constexpr double frame = 1.0 / 90;
    knead::Setup s = ball(32);
    add_tools(s);
    s.deterministic = true;
    const auto watched = gpu_solver(s, 0), left_alone = gpu_solver(s, 0);
    EXPECT_TRUE(watched->profile()->counts().empty());  // there was no frame yet
    FrameStats stats;
    const auto play = [&](int first) {
        for (int f = first; f < first + 3; ++f) {
            stats = watched->advance(closing(f * frame, frame), frame);
            left_alone->advance(closing(f * frame, frame), frame);
        }
    };
    play(0);
    std::string why;
    const std::vector<StageWork> once = counts_of(*watched, why), again = counts_of(*watched, why);
    if (!why.empty()) GTEST_SKIP() << why;
    const double items = double(s.particles.size()) * stats.substeps;
    const char* const names[] = {"sort", "pose", "p2g", "grid", "g2p"};
    ASSERT_EQ(once.size(), std::size(names));
    ASSERT_EQ(again.size(), std::size(names));
    for (std::size_t k = 0; k < std::size(names); ++k) {
        const DeviceWork &one = once[k].work, &other = again[k].work;
        EXPECT_EQ(once[k].name, names[k]);
        EXPECT_GT(one.instructions, 0) << names[k];
        EXPECT_NEAR(other.instructions / one.instructions, 1, 0.05) << names[k];
        EXPECT_GT(one.cache_bytes, 0) << names[k];
        EXPECT_GT(one.clock(), 1e8) << names[k];
        EXPECT_LT(one.clock(), 5e9) << names[k];
    }
    // A particle's state in and out, by way of level 2; a warp's instruction is one of 32
    // particles.
    EXPECT_GT(once[4].work.cache_bytes / items, 2 * sizeof(Particle<float>));
    EXPECT_GT(once[4].work.instructions / items, 100 / 32.0);
    EXPECT_LT(once[4].work.instructions / items, 10000 / 32.0);
    play(3);
    const auto places = [](const Simulator& solver) {
        std::vector<Vec3<double>> all;
        for (const Particle<double>& q : solver.particles()) all.push_back(q.x);
        return all;
    };
    EXPECT_TRUE(same_bits(places(*watched), places(*left_alone)));
}

TEST_F(GpuCounters, CountTheStagesOfASurfaceAndLeaveItAsItWas)
{
    const double h = 1.0 / 48;
    const auto particles = filled(h, 3, 0, ball({0.5, 0.5, 0.5}, 0.3));
    GpuSurface device(particles, {clay(h)}, rule_of(48));
    EXPECT_TRUE(device.stage_counts().empty());  // there is none yet
    const std::vector<Mesh> before = device.surface(particles);
    std::string why;
    const std::vector<StageWork> stages = counts_of(device, why);
    if (!why.empty()) GTEST_SKIP() << why;
    ASSERT_EQ(stages.size(), device.stage_times().size());
    for (const StageWork& stage : stages) EXPECT_GT(stage.work.cache_bytes, 0) << stage.name;
    EXPECT_TRUE(same_bits(device.meshes(), before));
}

}  // namespace
}  // namespace knead
