// Liquid that has come to rest: its particles keep one volume a cell (7a), not one each.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "host/bench/ball.h"
#include "host/solver/audit.h"
#include "tests/solver/back_ends.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test

// The preset's, in the paper's ball on 20^3 nodes, which falls at 2 m/s.
Given falling_liquid()
{
    Given s = ball(20);
    Material<double> m{};
    m.plasticity = Plasticity::fluid, m.density = 1400, m.bulk = 1400.0 * 30 * 30;
    m.exponent = 7, m.viscosity = 10;
    m.volume = s.materials[0].volume, m.mass = m.density * m.volume;
    s.materials = {m};
    for (Particle<double>& p : s.particles) p.v = {0, -2, 0};
    return rounded_to_float(s);
}

double deviation_of_log_volume(const std::vector<Particle<double>>& all, const Material<double>& m)
{
    double sum = 0, squares = 0;
    for (const Particle<double>& p : all) {
        const double log_J = log_volume_ratio(p, m);
        sum += log_J, squares += log_J * log_J;
    }
    const double mean = sum / double(all.size());
    return std::sqrt(squares / double(all.size()) - mean * mean);
}

using Liquid = AgainstTheReference;
INSTANTIATE_TEST_SUITE_P(Solver, Liquid, ::testing::ValuesIn(back_ends),
                         [](const auto& at) { return std::string(at.param.name); });

TEST_P(Liquid, ThatWasDroppedComesToRestAtHydrostaticPressureAndMakesNoEnergy)
{
    const Given s = falling_liquid();
    const Material<double>& m = s.materials[0];
    const auto solver = GetParam().make(s);
    const double frame = 1.0 / 30, weight = length(s.gravity), end = 4;
    const auto energy = [&](const std::vector<Particle<double>>& all) {
        const Audit a = audit(all, s.materials, s.lattice.dx);
        double height = 0;
        for (const Particle<double>& p : all) height += m.mass * p.x.y;
        return a.kinetic + a.elastic + weight * height;
    };
    const double first = energy(s.particles);
    double before = first, rise = 0;
    long substeps = 0;
    for (int f = 0; f < int(end / frame + 0.5); ++f) {
        substeps += solver->advance(Motion{}, frame).substeps;
        const double now = energy(solver->particles());
        rise = std::fmax(rise, now - before), before = now;
    }
    const std::vector<Particle<double>> all = solver->particles();
    const double volume = double(all.size()) * m.volume, edge = s.walls.max.x - s.walls.min.x,
                 depth = volume / (edge * edge);
    const double load = m.density * weight;  // [Pa/m]
    const double still = edge * edge * load * load * depth * depth * depth / (6 * m.bulk);
    const double noise = deviation_of_log_volume(all, m);
    const double elastic = audit(all, s.materials, s.lattice.dx).elastic;
    const double longest = s.step.courant * s.lattice.dx * std::sqrt(m.density / (3 * m.bulk));
    std::printf(
        "std ln J %.3g; elastic %.3g J, of hydrostatic %.3g J; rise %.3g J of %.3g; %ld "
        "substeps, at rest %.0f\n",
        noise, elastic, still, rise, first, substeps, end / longest);
    EXPECT_LT(noise, 1e-3);
    EXPECT_LT(elastic, 4 * still);
    EXPECT_GT(elastic, still / 4);
    EXPECT_LT(rise, 1e-3 * m.mass * double(all.size()) * 2);  // of its fall's energy
    EXPECT_LT(double(substeps), 1.1 * end / longest);
}

}  // namespace
}  // namespace knead
