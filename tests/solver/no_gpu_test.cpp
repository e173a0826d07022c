// Without a GPU, or in a build without CUDA, what needs one says so and nothing else happens.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/machine.h"
#include "host/bench/device.h"
#include "host/session/backend.h"
#include "host/share/shared_mesh.h"
#include "host/share/shared_splats.h"
#include "host/share/sharing.h"
#include "host/solver/gpu/material.h"
#include "host/solver/gpu/region_padding.h"
#include "host/solver/gpu/stages.h"
#include "host/splats/device_gaussians.h"
#include "host/splats/gpu_raster.h"
#include "host/surface/gpu_surface.h"
#include "tests/reason.h"

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
    const SurfaceOptions options{{{16, 16, 16}, 1.0f / 16}};
    EXPECT_THROW(GpuSurface(setup.particles, setup.materials, options), std::runtime_error);
    EXPECT_EQ(gpu_waits(), 0);
}

#ifndef KNEAD_HAS_CUDA
TEST_F(NoGpu, ABuildWithoutCudaMakesNothingOfTheDevice)
{
    const auto refuses = [](auto&& make) {
        const std::string why = reason<std::runtime_error>(make);
        EXPECT_NE(why.find("this build has no CUDA side"), std::string::npos) << why;
    };
    refuses([&] { gpu_solver(setup, 0, whole_lattice); });
    refuses([&] { gpu_answers({}, {}, 1.0f); });
    refuses([] { GpuRaster(SplatCloud{}, 0, 0); });
    refuses([] { const DeviceGaussians none(nullptr); });
    refuses([] { SharedMesh(0, MeshLayout{}, 0); });
    refuses([] { SharedSplats(0); });
    refuses([] { device_facts({DeviceKind::cuda, 0}, 1); });
    refuses([] { free_memory({DeviceKind::cuda, 0}); });
    EXPECT_FALSE(sharing(0).shared);
    EXPECT_NE(sharing(0).text.find("through host memory"), std::string::npos);
    EXPECT_EQ(gpu_bus(), "");
    EXPECT_FALSE(machine_facts(true)["gpu"].contains("name"));
    EXPECT_GT(free_memory({DeviceKind::cpu, 0}), std::size_t(1) << 20);
}
#endif

TEST_F(NoGpu, AutoIsTheCpuAndCudaIsRefused)
{
    EXPECT_EQ(resolved(parse_device("auto")).kind, DeviceKind::cpu);
    EXPECT_THROW(resolved(parse_device("cuda")), ResourceError);
    EXPECT_EQ(make_solver(setup, parse_device("auto"))->name().find("cpu float"), 0u);
    EXPECT_EQ(make_solver(setup, parse_device("cpu:double"))->clay(), nullptr);
}

}  // namespace
}  // namespace knead
