// Clay that hardly changes its volume bears the mean pressure of its cells (7a): which clay, that
// it does, and that all back ends do it alike.
#include "cuda/mpm/mean_pressure.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/bench/ball.h"
#include "host/solver/between.h"
#include "tests/solver/back_ends.h"
#include "tests/solver/clay.h"

namespace knead {
namespace {

using Given = Setup;  // the name is a member of testing::Test

constexpr double frame = 1.0 / 90;

Material<double> rubber(double poisson, Elasticity elasticity = Elasticity::neo_hookean)
{
    Material<double> m = clay<double>(elasticity, Plasticity::none);
    m.mu = 1e5 / (2 * (1 + poisson));
    m.lambda = 2 * m.mu * poisson / (1 - 2 * poisson);
    return m;
}

Material<double> water()
{
    Material<double> m = clay<double>(Elasticity::neo_hookean, Plasticity::fluid);
    m.mu = m.lambda = 0, m.bulk = 1e6, m.exponent = 7, m.viscosity = 1;
    return m;
}

// The ball on 32^3 nodes, of such rubber; every second particle is drawn out by a part in a
// thousand, the others are pressed as much, along all axes.
Given uneven_ball(const Material<double>& material)
{
    Given s = ball(32);
    const Material<double> own = s.materials[0];
    s.materials[0] = material;
    s.materials[0].mass = own.mass, s.materials[0].volume = own.volume;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const double e = i % 2 ? 2e-3 : -2e-3;
        s.particles[i].e = {e, e, e, 0, 0, 0};
    }
    return s;
}

double fastest(const std::vector<Particle<double>>& all)
{
    double most = 0;
    for (const Particle<double>& p : all) most = std::fmax(most, length(p.v));
    return most;
}

double farthest(const std::vector<Particle<double>>& a, const std::vector<Particle<double>>& b)
{
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) most = std::fmax(most, length(a[i].x - b[i].x));
    return most;
}

TEST(MeanPressure, IsThatOfSolidsAboveAPoissonsRatioOf45PercentAndOfLiquids)
{
    EXPECT_FALSE(shares_pressure(rubber(0.3)));
    EXPECT_FALSE(shares_pressure(rubber(0.45)));
    EXPECT_FALSE(shares_pressure(cast<float>(rubber(0.45))));
    EXPECT_TRUE(shares_pressure(rubber(0.46)));
    EXPECT_TRUE(shares_pressure(cast<float>(rubber(0.499))));
    EXPECT_TRUE(shares_pressure(water()));
    Material<double> nothing{};  // of an object that was removed
    EXPECT_FALSE(shares_pressure(nothing));
}

// A liquid's is a straight line of ln J, so that it has an inverse wherever its pressure goes (7).
TEST(MeanPressure, OfALiquidIsItsBulkModulusTimesTheLogarithmOfItsVolume)
{
    const Material<double> m = water();
    for (const double log_J : {-0.7, -1e-3, 0.0, 2e-4, 0.3}) {
        Particle<double> q{};
        q.e = isotropic(std::expm1(2.0 / 3 * log_J));
        EXPECT_NEAR(own_pressure(q, m), m.bulk * log_J, 1e-9 * m.bulk);
        EXPECT_NEAR(log_volume_at(m, 1.0, own_pressure(q, m)), log_J, 1e-12);
        if (std::fabs(log_J) > 1e-2 || log_J == 0) continue;
        EXPECT_NEAR(trace(kirchhoff_stress(q, m)) / 3, own_pressure(q, m),
                    5 * std::fabs(log_J) * std::fabs(own_pressure(q, m)));
    }
}

// The isotropic part of the stress, but for what mu gives to it: mu (I1 / 3 - 1) of neo-Hookean
// clay, nothing of Hencky's; of fixed corotated clay of equal stretches s, 2 mu (s - 1) s.
TEST(MeanPressure, OfAParticleIsWhatItsVolumeGivesToItsStress)
{
    const double s = 1.01, e = s * s - 1, J = s * s * s;
    for (const Elasticity elasticity : elasticities) {
        const Material<double> m = rubber(0.49, elasticity);
        Particle<double> q{};
        q.e = {e, e, e, 0, 0, 0};
        const double by_mu = elasticity == Elasticity::neo_hookean       ? m.mu * e
                             : elasticity == Elasticity::fixed_corotated ? 2 * m.mu * (s - 1) * s
                                                                         : 2 * m.mu * std::log(s);
        const double by_volume = elasticity == Elasticity::fixed_corotated ? m.lambda * (J - 1) * J
                                                                           : m.lambda * std::log(J);
        EXPECT_NEAR(own_pressure(q, m), by_volume, 1e-9 * by_volume);
        EXPECT_NEAR(trace(kirchhoff_stress(q, m)) / 3, by_mu + by_volume, 1e-9 * by_volume);
    }
}

TEST(MeanPressure, IsWeightedByVolume)
{
    PressureSum<double> sum;
    sum.add(6, 1), sum.add(-3, 2);
    EXPECT_DOUBLE_EQ(sum.mean(), 0);
    sum.add(9, 3);
    EXPECT_DOUBLE_EQ(sum.mean(), 4.5);
}

TEST(MeanPressure, IsBorneInPartAndInTheEndWhollyAndTheShapeStays)
{
    for (const Elasticity elasticity : elasticities)
        for (const double wanted : {-2e4, 0.0, 3e5}) {
            const Material<double> m = rubber(0.49, elasticity);
            Particle<double> q{};
            q.e = {0.1, -0.05, 0.02, 0.03, -0.02, 0.01};
            const Particle<double> first = q;
            const double before = own_pressure(q, m);
            apply_mean_pressure(q, m, wanted);
            const double way = log_volume_at(m, 1.0, wanted) - ln_J(first);
            EXPECT_NEAR(ln_J(q) - ln_J(first), part_borne<double> * way, 1e-12);
            for (int k = 0; k < 100; ++k) apply_mean_pressure(q, m, wanted);
            EXPECT_NEAR(own_pressure(q, m), wanted, 1e-6 * std::fabs(wanted - before));
            const double scale = (1 + q.e.xx) / (1 + first.e.xx);
            const auto scaled = [&](double e) { return scale * (1 + e) - 1; };
            EXPECT_NEAR(q.e.yy, scaled(first.e.yy), 1e-12);
            EXPECT_NEAR(q.e.zz, scaled(first.e.zz), 1e-12);
            EXPECT_NEAR(q.e.xy, scale * first.e.xy, 1e-12);
        }
}

using EachBackEnd = AgainstTheReference;
INSTANTIATE_TEST_SUITE_P(MeanPressure, EachBackEnd, ::testing::ValuesIn(back_ends),
                         [](const auto& at) { return std::string(at.param.name); });

// Eight particles about the middle of a cell, of which four are drawn out and four are pressed,
// push each other along x, until they bear the same: four substeps' worth of 100.
TEST_P(EachBackEnd, OfUnevenVolumesInACellTheMeanPushes)
{
    Given s = ball(32);
    const double dx = s.lattice.dx;
    s.gravity = {0, 0, 0}, s.step.fixed = 1e-6;
    const Material<double> own = s.materials[0];
    s.particles.resize(8);
    for (int i = 0; i < 8; ++i) {
        const double e = i & 1 ? 2e-3 : 1 / (1 + 2e-3) - 1;  // opposite logarithms
        const auto along = [&](int high) { return dx * (16 + (high ? 1.25 : 0.75)); };
        s.particles[std::size_t(i)] = {
            {along(i & 1), along(i & 2), along(i & 4)}, {}, {}, {e, e, e, 0, 0, 0}, 0, 0, 0};
    }
    const auto pushed = [&](const Material<double>& m) {
        s.materials[0] = m;
        s.materials[0].mass = own.mass, s.materials[0].volume = own.volume;
        const auto solver = GetParam().make(s);
        solver->advance(Motion{}, 1e-4);
        return fastest(solver->particles());
    };
    const Material<double> m = rubber(0.499);
    Material<double> alone = m;
    alone.mu = m.lambda / 9;  // just too much to share its pressure
    EXPECT_GT(pushed(alone), 10 * pushed(m));
    Material<double> liquid = water();
    liquid.bulk = m.lambda, liquid.viscosity = 0;
    EXPECT_GT(pushed(alone), 10 * pushed(liquid));
}

// Liquids of two bulk moduli and rubber, in the same cells.
TEST_P(EachBackEnd, LiquidsAndRubberInOneCellMoveAsInTheReference)
{
    Given s = uneven_ball(rubber(0.49));
    const double dx = s.lattice.dx;
    for (const double bulk : {1e6, 2e5}) {
        Material<double> m = water();
        m.bulk = bulk;
        m.mass = s.materials[0].mass, m.volume = s.materials[0].volume;
        s.materials.push_back(m);
    }
    for (Particle<double>& p : s.particles) {
        p.object = p.x.x < 0.5 + dx / 4 ? p.x.y < 0.5 + dx / 4 ? 0 : 1 : 2;
        p.v = {0, -2, 0};
    }
    s = rounded_to_float(s);
    const auto solver = GetParam().make(s);
    Reference reference(s);
    int substeps = 0;
    for (int f = 0; f < 4; ++f) {
        EXPECT_EQ(solver->advance(Motion{}, frame)[Count::repaired], 0);
        substeps += reference.advance(Motion{}, frame).substeps;
    }
    EXPECT_GT(substeps, 100);
    EXPECT_LT(farthest(solver->particles(), reference.particles()), 1e-2 * dx);
}

// A hundred substeps, with tools.
TEST_P(EachBackEnd, RubberBetweenToolsMovesAsInTheReference)
{
    for (const Plasticity plasticity : {Plasticity::none, Plasticity::von_mises}) {
        SCOPED_TRACE(int(plasticity));
        Given s = uneven_ball(rubber(0.49));
        s.materials[0].plasticity = plasticity, s.materials[0].yield = 2e3;
        add_tools(s);
        s = rounded_to_float(s);
        const auto solver = GetParam().make(s);
        Reference reference(s);
        int substeps = 0;
        for (int f = 0; f < 4; ++f) {
            const Motion m = closing(f * frame, frame);
            const FrameStats mine = solver->advance(m, frame);
            substeps += reference.advance(m, frame).substeps;
            EXPECT_EQ(mine[Count::repaired], 0);
        }
        EXPECT_GT(substeps, 100);
        EXPECT_LT(farthest(solver->particles(), reference.particles()), 1e-2 * s.lattice.dx);
    }
}

// Where a blade has been, and where clay may be still, other loops and kernels do it.
TEST_P(EachBackEnd, CutAndRestingRubberMovesAsInTheReference)
{
    Given s = uneven_ball(rubber(0.49));
    add_tools(s);
    s.tools[0].blade = true;
    s = rounded_to_float(s);
    Given resting = s;
    resting.rest.mode = RestMode::sleep, resting.rest.frames = 1000;
    Reference reference(s);
    const auto solver = GetParam().make(s), still = GetParam().make(resting);
    for (int f = 0; f < 3; ++f) {
        const Motion m = closing(f * frame, frame);
        reference.advance(m, frame), solver->advance(m, frame), still->advance(m, frame);
    }
    EXPECT_LT(farthest(solver->particles(), reference.particles()), 5e-3 * s.lattice.dx);
    EXPECT_LT(farthest(still->particles(), reference.particles()), 5e-3 * s.lattice.dx);
}

TEST_P(EachBackEnd, AFrameAfterARestoreIsTheSame)
{
    if (GetParam().device && !GetParam().deterministic) return;  // sums come in any order
    Given s = uneven_ball(rubber(0.49));
    add_tools(s);
    const auto solver = GetParam().make(s);
    solver->advance(closing(0, frame), frame);
    const auto kept = solver->snapshot();
    solver->advance(closing(frame, frame), frame);
    const std::vector<Particle<double>> once = solver->particles();
    solver->restore(*kept);
    solver->advance(closing(frame, frame), frame);
    EXPECT_EQ(farthest(once, solver->particles()), 0);
}

}  // namespace
}  // namespace knead
