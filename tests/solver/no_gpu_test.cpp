// Without a GPU, or in a build without CUDA, what needs one says so and nothing else happens.
#include <gtest/gtest.h>

#include "host/base/errors.h"
#include "host/session/device.h"
#include "host/solver/gpu/material.h"
#include "host/solver/gpu/stages.h"
#include "host/surface/gpu_surface.h"

namespace knead {
namespace {

Setup one_particle()
{
    Setup s{};
    s.lattice = {{16, 16, 16}, 1.0 / 16};
    s.walls = walls_inside(s.lattice, 3, ContactMode::separate, 0);
    Material<double> m{};
    m.density = 1000, m.mu = m.lambda = 1e4, m.volume = 1e-6, m.mass = 1e-3;
    s.materials = {m};
    Particle<double> q{};
    q.x = {0.5, 0.5, 0.5};
    s.particles = {q};
    return s;
}

class NoGpu : public testing::Test {
  protected:
    void SetUp() override
    {
        if (gpu_present()) GTEST_SKIP() << "a GPU is here";
    }
    const knead::Setup setup = one_particle();
};

TEST_F(NoGpu, EveryWayToOneThrows)
{
    EXPECT_THROW(gpu_solver(setup, 0), std::runtime_error);
    EXPECT_THROW(GpuStages(setup, {}, 1e-3), std::runtime_error);
    EXPECT_THROW(gpu_functions({1.0f}), std::runtime_error);
    const SurfaceRule rule{{{16, 16, 16}, 1.0f / 16}};
    EXPECT_THROW(GpuSurface(setup.particles, setup.materials, rule), std::runtime_error);
    EXPECT_EQ(gpu_waits(), 0);
}

TEST_F(NoGpu, AutoIsTheCpuAndCudaIsRefused)
{
    EXPECT_EQ(resolved(parse_device("auto")).kind, DeviceKind::cpu);
    EXPECT_THROW(resolved(parse_device("cuda")), ResourceError);
    EXPECT_EQ(make_solver(setup, parse_device("auto"))->name().find("cpu float"), 0u);
    EXPECT_EQ(make_solver(setup, parse_device("cpu:double"))->clay(), nullptr);
}

}  // namespace
}  // namespace knead
