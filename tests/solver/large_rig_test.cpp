// Rigs are what callers make them: any number of joints, not two hands of 26.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>

#include "host/bench/ball.h"
#include "host/solver/editable_simulator.h"
#include "host/solver/reference.h"

namespace knead {
namespace {

constexpr double frame = 1.0 / 90;
using Maker = std::function<std::unique_ptr<EditableSimulator>(const Setup&)>;

// A necklace of many joints, more than two hands have and more than a kernel stages at a time.
void expect_the_references(const Maker& make)
{
    constexpr int beads = 80;
    Setup s = ball(32);
    s.rig = {}, s.tools = {{ContactMode::separate, 0.2, false, true}};
    for (int i = 0; i < beads; ++i) {
        Binding<float> b{};
        b.joint[0] = i, b.joint[1] = (i + 1) % beads;
        b.weight[0] = 0.5f, b.weight[1] = 0.5f;
        b.radius = 0.02f;
        s.rig.spheres.push_back(b);
        s.rig.primitives.push_back({1, {i, i, i}, 0});
    }
    const auto ring = [](double turn, double height) {
        std::vector<Joint<double>> joints;
        for (int i = 0; i < beads; ++i) {
            const double angle = turn + 6.283185307179586 * i / beads;
            joints.push_back({turn_about(Vec3<double>{0, 1, 0}, angle),
                              {0.42 + 0.1 * std::cos(angle), height, 0.5 + 0.1 * std::sin(angle)}});
        }
        return joints;
    };
    const auto play_ring = [&](Simulator& solver) {
        // One frame: the beads are smaller than a cell, and each frame multiplies by some 20 what
        // rounding made of a depth.
        return solver.advance({ring(0, 0.58), ring(0.05, 0.57), {1}}, frame)[Count::projected];
    };
    const auto solver = make(s);
    Reference reference(s);
    const long mine = play_ring(*solver), wanted = play_ring(reference);
    EXPECT_GT(wanted, 1000);
    EXPECT_NEAR(double(mine), double(wanted), 0.02 * double(wanted));
    const auto a = solver->particles(), b = reference.particles();
    double sum = 0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += dot(a[i].x - b[i].x, a[i].x - b[i].x);
    if (std::getenv("KNEAD_SHOW"))
        std::printf("rms %.2g cells\n", std::sqrt(sum / double(a.size())) / s.lattice.dx);
    EXPECT_LT(std::sqrt(sum / double(a.size())), 3e-4 * s.lattice.dx);
    Motion motion{ring(0, 0.6), ring(0, 0.6), {1}};
    motion.to.pop_back();
    EXPECT_THROW(solver->advance(motion, frame), std::invalid_argument);
}

TEST(LargeRig, PressesAsTheReferencesDoes)
{
    expect_the_references([](const auto& s) { return cpu_solver(s); });
}

TEST(LargeRig, PressesAsTheReferencesDoesOnAGpu)
{
    if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    expect_the_references([](const auto& s) { return gpu_solver(s, 0); });
}

}  // namespace
}  // namespace knead
