// Kernels of a substep that overlap in time compute the same bits as kernels in plain stream order.
#include <gtest/gtest.h>

#include <string>

#include "host/bench/ball.h"
#include "host/solver/editable_simulator.h"
#include "host/solver/gpu/overlaps.h"
#include "tests/solver/same_bits.h"
#include "tests/solver/stepwise.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test

constexpr double frame = 1.0 / 90;

Given squeezed_ball()
{
    Given s = ball(32);
    add_tools(s);
    s.deterministic = true;
    return s;
}

// Stages that only some scenes have: Gaussians; cell-averaged pressure; sleep; a blade, with which
// Gaussians are moved out of tools in substeps, too.
Given with_gaussians()
{
    Given s = squeezed_ball();
    add_gaussians(s, 2000);
    return s;
}
Given with_mean_pressure()
{
    Given s = squeezed_ball();
    Material<double>& m = s.materials[0];
    m.lambda = 40 * m.mu;
    return s;
}
Given with_sleep()
{
    Given s = squeezed_ball();
    s.rest = {RestMode::sleep, 0.05, 2, 4.9, 4 * s.lattice.dx};
    return s;
}
Given with_a_blade()
{
    Given s = with_gaussians();
    const int first = int(s.rig.spheres.size());
    for (const Vec3<float>& corner : {Vec3<float>{0.1f, 0, -0.2f}, {0.1f, 0, 0.2f}, {0.3f, 0, 0}}) {
        Binding<float> b{};
        for (int& j : b.joint) j = wrist;
        b.weight[0] = 1, b.offset[0] = corner, b.radius = 1e-3f;
        s.rig.spheres.push_back(b);
    }
    s.rig.primitives.push_back({3, {first, first + 1, first + 2}, 2});
    s.tools.push_back({ContactMode::separate, 0.1, true, true});
    return s;
}

struct Scene {
    const char* name;
    Given (*make)();
};
constexpr Scene scenes[] = {{"tools", squeezed_ball},
                            {"gaussians", with_gaussians},
                            {"mean_pressure", with_mean_pressure},
                            {"sleep", with_sleep},
                            {"blade", with_a_blade}};

struct End {
    std::vector<Particle<double>> particles;
    std::vector<Gaussian<double>> gaussians;
    long substeps = 0, projected = 0;
};

// After some frames with these overlaps, by graphs or launch by launch.
End played(const Given& scene, unsigned overlaps, bool graphs)
{
    const gpu::WithOverlaps only(overlaps);
    const auto solver = [&] {
        if (graphs) return gpu_solver(scene, 0);
        const Stepwise stepwise;
        return gpu_solver(scene, 0);
    }();
    End end;
    for (int f = 0; f < 8; ++f) {
        const FrameStats stats = solver->advance(closing(f * frame, frame), frame);
        end.substeps += stats.substeps, end.projected += stats[Count::projected];
    }
    end.particles = solver->particles(), end.gaussians = solver->gaussians();
    return end;
}

void expect_same(const End& a, const End& b)
{
    EXPECT_TRUE(same_bits(a.particles, b.particles));
    EXPECT_TRUE(same_bits(a.gaussians, b.gaussians));
    EXPECT_EQ(a.substeps, b.substeps);
    EXPECT_EQ(a.projected, b.projected);
}

class GpuOverlap : public ::testing::TestWithParam<Scene> {
  protected:
    void SetUp() override
    {
        if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
};

TEST_P(GpuOverlap, PlainStreamOrderGivesTheSameBitsInGraphsAndInDirectLaunches)
{
    const Given scene = GetParam().make();
    const End usual = played(scene, overlap::all, true);
    EXPECT_GT(usual.projected, 0);
    {
        SCOPED_TRACE("graphs in plain stream order");
        expect_same(played(scene, overlap::none, true), usual);
    }
    {
        SCOPED_TRACE("direct launches that overlap");
        expect_same(played(scene, overlap::all, false), usual);
    }
    {
        SCOPED_TRACE("direct launches in plain stream order");
        expect_same(played(scene, overlap::none, false), usual);
    }
}

TEST_P(GpuOverlap, EachOneCanBeSwitchedOffAlone)
{
    const Given scene = GetParam().make();
    const End usual = played(scene, overlap::all, true);
    for (unsigned bit = 1; bit < overlap::all; bit *= 2) {
        SCOPED_TRACE(bit);
        expect_same(played(scene, overlap::all & ~bit, true), usual);
        expect_same(played(scene, bit, true), usual);
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, GpuOverlap, ::testing::ValuesIn(scenes),
                         [](const auto& of) { return std::string(of.param.name); });

}  // namespace
}  // namespace knead
