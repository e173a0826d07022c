// Snow that is thrown against a floor gives up energy, whatever its Poisson's ratio.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <stdexcept>

#include "host/bench/ball.h"
#include "host/solver/audit.h"
#include "tests/solver/back_ends.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test

Given thrown_snow(double poisson, double compress, double hardening)
{
    Given s = ball(24);
    Material<double> m{};
    m.elasticity = Elasticity::fixed_corotated, m.plasticity = Plasticity::clamp;
    m.density = 400;
    m.mu = 1.7e6 / (2 * (1 + poisson)), m.lambda = 2 * m.mu * poisson / (1 - 2 * poisson);
    m.bulk = m.lambda + 2 * m.mu / 3;
    m.compress = compress, m.stretch = 0.0075, m.snow = hardening;
    m.volume = s.materials[0].volume, m.mass = m.density * m.volume;
    s.materials = {m}, s.gravity = {0, 0, 0};
    s.walls.mode = ContactMode::slip;
    for (Particle<double>& p : s.particles) p.v = {0, -3, 0};
    return rounded_to_float(s);
}

using Snow = AgainstTheReference;
INSTANTIATE_TEST_SUITE_P(Solver, Snow, ::testing::ValuesIn(back_ends),
                         [](const auto& at) { return std::string(at.param.name); });

// Clamped whatever its stress is, the first ball had nine times its energy in half a second.
TEST_P(Snow, NeverHasMoreEnergyThanItWasThrownWith)
{
    for (const auto& [poisson, compress, hardening] :
         {std::array{0.4, 0.1, 0.0}, std::array{0.4, 0.1, 3.0}, std::array{0.2, 0.025, 10.0}}) {
        const Given s = thrown_snow(poisson, compress, hardening);
        const auto solver = GetParam().make(s);
        const auto energy = [&](const std::vector<Particle<double>>& all) {
            const Audit a = audit(all, s.materials, s.lattice.dx);
            return a.kinetic + a.elastic;
        };
        const double first = energy(s.particles);
        double most = 0, rise = 0, before = first;
        for (int f = 0; f < 40; ++f) {
            solver->advance(Motion{}, 0.3 / 40);
            const double now = energy(solver->particles());
            most = std::fmax(most, now), rise = std::fmax(rise, now - before), before = now;
        }
        std::printf("nu %g compress %g snow %g: %.4g J, at most %.4g, last %.4g, rise %.3g\n",
                    poisson, compress, hardening, first, most, before, rise);
        EXPECT_LT(most, first * (1 + 1e-5));
        EXPECT_LT(rise, 0.01 * first);
        EXPECT_LT(before, 0.2 * first);  // it has landed
    }
}

// Packed alike on all sides, harder snow would store more than the flow gives up.
TEST_P(Snow, ThatMakesEnergyAsItIsPackedIsRefused)
{
    Given s = thrown_snow(0.2, 0.025, 10);
    const auto solver = GetParam().make(s);
    const std::vector<Particle<double>> before = solver->particles();
    for (const auto& [compress, hardening] : {std::pair{0.1, 12.0}, std::pair{0.025, 24.0}}) {
        Material<double> packs = s.materials[0];
        packs.compress = compress, packs.snow = hardening;
        EXPECT_THROW(solver->set_material(0, packs), std::invalid_argument);
        EXPECT_THROW(solver->add(packs, {s.particles[0]}), std::invalid_argument);
        s.materials[0] = packs;
        EXPECT_THROW(GetParam().make(s), std::invalid_argument);
        packs.plasticity = Plasticity::none;  // of which they are no constants
        solver->set_material(0, packs);
    }
    EXPECT_EQ(solver->particles().size(), before.size());
}

}  // namespace
}  // namespace knead
