// The order in which a frame's runs of particles come on the device.
#include <gtest/gtest.h>

#include <vector>

#include "cuda/contact/contact.h"
#include "cuda/mpm/features.h"
#include "host/bench/ball.h"
#include "host/solver/gpu/stages.h"

namespace knead {
namespace {

constexpr std::size_t run_size = run_length({});

// Whether tools may touch each run of the scene's particles, by the blocks' masks.
std::vector<bool> near_tools(const knead::Setup& s, const std::vector<Mask>& masks)
{
    const Lattice<float> lattice{s.lattice.size, float(s.lattice.dx)};
    std::vector<bool> near((s.particles.size() + run_size - 1) / run_size);
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const int block = lattice.block_of(lattice.cell_of(cast<float>(s.particles[i].x)));
        if (!empty(masks[std::size_t(block)])) near[i / run_size] = true;
    }
    return near;
}

TEST(LineUp, RunsNearToolsComeFirstAndTheMiddleOfTheOthersLast)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    for (const int nodes : {16, 60, 64, 96}) {
        knead::Setup s = ball(nodes);
        add_tools(s);
        GpuStages stages(s, {wrists(0.25, 0.1), wrists(0.2499, 0.1004), {1, 1}}, 1e-4);
        const std::vector<bool> near = near_tools(s, stages.masks());
        std::vector<int> expected, far;
        for (std::size_t run = 0; run < near.size(); ++run)
            (near[run] ? expected : far).push_back(int(run));
        EXPECT_GT(expected.size(), 0u);
        EXPECT_GE(far.size(), nodes < 60 ? 0u : 21u);
        for (auto low = far.begin(), high = far.end(); low != high;) {
            expected.push_back(*low++);
            if (low != high) expected.push_back(*--high);
        }
        EXPECT_EQ(stages.lined_up(), expected) << nodes;
    }
}

}  // namespace
}  // namespace knead
