// Rounding of clay to the steps of the quantised codec, against bounds in double.
#include "host/session/quantisation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "cuda/math/sym_eigen.h"
#include "host/bench/ball.h"
#include "host/scene/presets.h"
#include "host/session/capture.h"
#include "host/solver/editable_simulator.h"
#include "tests/session/clay_rows.h"

namespace knead {
namespace {

// Steps of a lattice of `nodes` nodes a metre, with walls at these places.
Quantisation steps_of(double dx, Vec3<double> low, Vec3<double> high)
{
    SimulationConfig config;
    config.lattice.dx = dx;
    config.walls.min = low, config.walls.max = high;
    config.materials.resize(3);
    config.materials[1].mu = 1e9, config.materials[1].yield = 1e6;
    config.materials[2].mu = 1e4, config.materials[2].yield = 1e4;
    return quantisation_of(config);
}
Quantisation steps_of_three() { return steps_of(0.013, {0.03, 0.03, 0.03}, {0.97, 1.77, 0.97}); }

// Numbers of the size that clay has, of three objects and between the walls of steps_of_three().
ClayRows some_clay(std::mt19937& random, std::size_t particles, std::size_t gaussians)
{
    ClayRows rows = random_rows(random, particles, gaussians);
    std::uniform_real_distribution<float> place(0.03f, 0.97f);
    std::normal_distribution<float> strain(0, 0.03f);
    const auto places = [&]() -> Vec3<float> {
        return {place(random), place(random), place(random)};
    };
    for (std::size_t i = 0; i < particles; ++i) {
        Particle<float> q = particle_at(rows, i);
        q.x = places();
        for (float* e : {&q.e.xx, &q.e.yy, &q.e.zz, &q.e.xy, &q.e.xz, &q.e.yz}) *e = strain(random);
        q.k = 10 * std::fabs(strain(random));
        set_particle(rows, i, q);
    }
    for (Gaussian<float>& g : rows.gaussians) {
        g.x = places(), g.F = diagonal(1.0f);
        for (Vec3<float>* c : {&g.F.a, &g.F.b, &g.F.c})
            *c = *c + Vec3<float>{strain(random), strain(random), strain(random)};
    }
    return rows;
}

TEST(Quantisation, TheStepOfStrainIsAShareOfTheYieldStrain)
{
    const std::map<std::string, float> known{
        {"clay", 0x1p-12f}, {"soft-clay", 0x1p-12f}, {"plasticine", 0x1p-12f}, {"dough", 0x1p-12f}};
    for (const auto& [name, step] : known) {
        const Material<double> m = made(material_spec(name));
        EXPECT_EQ(e_step_of(m.mu, m.yield), step) << name;
    }
    EXPECT_EQ(e_step_of(1e6, 0), 0x1p-12f);
    EXPECT_EQ(e_step_of(0, 1e3), 0x1p-12f);
    for (double ratio = 1e-3; ratio < 3; ratio *= 1.07) {
        const double step = double(e_step_of(1e5, ratio * 1e5)),
                     most = 0.005 * std::sqrt(2.0 / 3) * ratio;
        EXPECT_LE(step, most);
        EXPECT_GT(2 * step, most);
        EXPECT_EQ(std::exp2(std::round(std::log2(step))), step);
    }
    EXPECT_EQ(e_step_of(1e9, 1), 0x1p-18f);
    EXPECT_EQ(e_step_of(1, 1e9), 0x1p-6f);
    const Quantisation steps = steps_of_three();
    EXPECT_EQ(steps.x, float(0.013 / 1024));
    EXPECT_EQ(steps.of_object(0), 0x1p-12f);
    EXPECT_EQ(steps.of_object(1), 0x1p-18f);
    EXPECT_EQ(steps.of_object(2), 0x1p-8f);
    EXPECT_EQ(steps.of_object(-1), 0x1p-12f);
    EXPECT_EQ(steps.of_object(3), 0x1p-12f);
}

// A whole number of steps, at most half a step away. `rounding`: of floats, relative to the number.
void expect_near(float now, float before, float step, double rounding)
{
    const double whole = std::round(double(now) / double(step));
    EXPECT_NEAR(double(now), whole * double(step), rounding * std::fabs(double(now)));
    EXPECT_LE(std::fabs(double(now) - double(before)),
              0.5 * double(step) + rounding * std::fabs(double(before)));
}

TEST(Quantisation, EachNumberIsHalfAStepAwayAtMost)
{
    std::mt19937 random(1);
    const Quantisation steps = steps_of_three();
    const ClayRows rows = some_clay(random, 20000, 2000), now = quantised(rows, steps);
    EXPECT_EQ(now.object, rows.object);
    EXPECT_EQ(now.sides, rows.sides);
    const auto expect_place = [&](Vec3<float> at, Vec3<float> before) {
        for (const auto& [a, b] : {std::pair{at.x, before.x}, {at.y, before.y}, {at.z, before.z}})
            expect_near(a, b, steps.x, 0x1p-22);
    };
    for (std::size_t i = 0; i < rows.count && !testing::Test::HasFailure(); ++i) {
        const Particle<float> a = particle_at(now, i), b = particle_at(rows, i);
        const float e = steps.of_object(b.object);
        expect_place(a.x, b.x);
        for (const auto& [p, q] : {std::pair{a.e.xx, b.e.xx},
                                   {a.e.yy, b.e.yy},
                                   {a.e.zz, b.e.zz},
                                   {a.e.xy, b.e.xy},
                                   {a.e.xz, b.e.xz},
                                   {a.e.yz, b.e.yz}})
            expect_near(p, q, e, 0);
        expect_near(a.k, b.k, k_step, 0);
    }
    for (std::size_t i = 0; i < rows.gaussians.size() && !testing::Test::HasFailure(); ++i) {
        const Gaussian<float>&a = now.gaussians[i], &b = rows.gaussians[i];
        expect_place(a.x, b.x);
        EXPECT_EQ(a.object, b.object);
        EXPECT_EQ(a.sides, b.sides);
        for (const auto& [p, q] : {std::pair{a.F.a, b.F.a}, {a.F.b, b.F.b}, {a.F.c, b.F.c}})
            for (const auto& [s, t] : {std::pair{p.x, q.x}, {p.y, q.y}, {p.z, q.z}})
                expect_near(s, t, F_step, 0);
    }
}

TEST(Quantisation, RoundedRowsStayTheSame)
{
    std::mt19937 random(2);
    const Quantisation others[] = {steps_of_three(),
                                   steps_of(1.0 / 64, {0.05, 0.05, 0.05}, {0.9, 0.9, 0.9}),
                                   steps_of(0.3, {0.7, 1, 1}, {600, 601, 555.5})};
    for (const Quantisation& steps : others)
        for (const bool any : {false, true}) {
            const ClayRows rows =
                any ? random_rows(random, 20000, 500) : some_clay(random, 20000, 500);
            const ClayRows once = quantised(rows, steps);
            EXPECT_TRUE(same_rows(quantised(once, steps), once));
        }
}

// Also of a strain that the solver's rounding has made impossible.
TEST(Quantisation, NoEigenvalueOfTheStrainBecomesNegative)
{
    std::mt19937 random(3);
    std::uniform_real_distribution<double> one(-1, 1);
    const QuantStep step = quant_step(0x1p-12f);
    int corrected = 0;
    for (int i = 0; i < 100000; ++i) {
        // b = F F^T of a body that is pressed flat, down to 0.3 % of its thickness.
        const Vec3<double> axis{one(random), one(random), one(random)};
        const Quat<double> q = turn_about((1 / length(axis)) * axis, 3 * one(random));
        const double flat = std::pow(10, -2.5 + 0.5 * one(random));
        const Vec3<double> a = rotate(q, {1, 0, 0}), b = rotate(q, {0, 1.1, 0}),
                           c = rotate(q, {0, 0, flat});
        const Mat3<double> all = outer(a, a) + outer(b, b) + outer(c, c);
        const Sym3<float> e = {float(all.a.x - 1), float(all.b.y - 1), float(all.c.z - 1),
                               float(all.b.x),     float(all.c.x),     float(all.c.y)};
        if (!positive_definite(e)) continue;
        const Sym3<float> now = quantised(e, step);
        const Sym3<double> m{1.0 + now.xx, 1.0 + now.yy, 1.0 + now.zz, now.xy, now.xz, now.yz};
        const Vec3<double> value = eigen(m).value;
        EXPECT_GT(std::min({value.x, value.y, value.z}), -1e-7);
        const float nearest = quantised(e.xx, step);
        if (now.xx != nearest) ++corrected;
        EXPECT_LE(std::fabs(now.xx - nearest), 2 * step.size);
    }
    EXPECT_GT(corrected, 1000);
}

TEST(Quantisation, RowsAreRoundedByTheFormulas)
{
    std::mt19937 random(7);
    const Quantisation steps = steps_of_three();
    ClayRows rows = some_clay(random, 3000, 0);
    for (std::size_t i = 0; i < rows.count; i += 1 + random() % 40) {  // flat: b.zz is below 1e-4
        Particle<float> q = particle_at(rows, i);
        q.e = {0.1f, 0.1f, -1 + 1e-4f * float(random() % 100) / 100, 0, 1e-5f, 1e-5f};
        set_particle(rows, i, q);
    }
    const ClayRows now = quantised(rows, steps);
    int corrected = 0;
    for (std::size_t i = 0; i < rows.count; ++i) {
        const Particle<float> q = particle_at(rows, i);
        const QuantStep e = quant_step(steps.of_object(q.object));
        Particle<float> expected = particle_at(now, i);
        expected.e = quantised(q.e, e);
        expected.k = quantised(q.k, quant_step(k_step));
        corrected += expected.e.xx != quantised(q.e.xx, e);
        ClayRows one = empty_rows(1), other = one;
        set_particle(one, 0, expected), set_particle(other, 0, particle_at(now, i));
        EXPECT_TRUE(same_rows(one, other)) << i;
    }
    EXPECT_GT(corrected, 20);
}

TEST(Quantisation, HalfAxesOfASplatChangeByLessThanAThousandth)
{
    std::mt19937 random(4);
    std::uniform_real_distribution<double> one(-1, 1);
    const auto turn = [&] {
        const Vec3<double> axis{one(random), one(random), one(random)};
        return turn_about((1 / length(axis)) * axis, 3 * one(random));
    };
    const auto times = [](const Mat3<double>& m, Vec3<double> s, Quat<double> q) {
        return Mat3<double>{m * rotate(q, {s.x, 0, 0}), m * rotate(q, {0, s.y, 0}),
                            m * rotate(q, {0, 0, s.z})};
    };
    const auto half_axes = [](const Mat3<double>& m) {
        const Mat3<double> s = outer(m.a, m.a) + outer(m.b, m.b) + outer(m.c, m.c);
        Vec3<double> v = eigen(symmetric(s)).value;
        if (v.x > v.y) std::swap(v.x, v.y);
        if (v.y > v.z) std::swap(v.y, v.z);
        if (v.x > v.y) std::swap(v.x, v.y);
        return Vec3<double>{std::sqrt(v.x), std::sqrt(v.y), std::sqrt(v.z)};
    };
    double worst = 0;
    for (int i = 0; i < 100000; ++i) {
        const auto stretch = [&] { return std::exp2(1.3 * one(random)); };
        const Mat3<double> F = times(times(diagonal(1.0), {1, 1, 1}, turn()),
                                     {stretch(), stretch(), stretch()}, turn());
        ClayRows rows;
        rows.gaussians = {{{0.5f, 0.5f, 0.5f}, {}, 0, uncut}};
        rows.gaussians[0].F = {cast<float>(F.a), cast<float>(F.b), cast<float>(F.c)};
        const Gaussian<double> now = cast<double>(quantised(rows, steps_of_three()).gaussians[0]);
        const Quat<double> q = turn();
        const Vec3<double> s{1, std::exp2(-3 + 3 * one(random)), std::exp2(-4 + 3 * one(random))};
        const Vec3<double> a = half_axes(times(F, s, q)), b = half_axes(times(now.F, s, q));
        for (const auto& [p, r] : {std::pair{a.x, b.x}, {a.y, b.y}, {a.z, b.z}})
            worst = std::max(worst, std::fabs(r / p - 1));
    }
    EXPECT_LT(worst, 1e-3);
    EXPECT_GT(worst, 1e-4);
}

// Particles on walls that lie on no step, on the last float before them, and behind them.
TEST(Quantisation, TheSimulatorAcceptsAllRoundedRows)
{
    std::mt19937 random(5);
    for (const double shift : {0.0, 1e-9, 0.3e-4, 0.0123}) {
        knead::Setup s = ball(24);
        s.walls.min = s.walls.min + Vec3<double>{shift, 0.7 * shift, 0.1 * shift};
        s.walls.max = s.walls.max - Vec3<double>{0.9 * shift, 0.2 * shift, 1.7 * shift};
        s.gaussians.push_back(gaussian_at(s.particles[0].x, 0));
        const auto solver = cpu_solver(s);
        const Quantisation steps = quantisation_of(solver->config());
        ClayRows rows = solver->rows(*solver->snapshot());
        const Vec3<float> low = cast<float>(s.walls.min), high = cast<float>(s.walls.max);
        const auto near = [&](float face) {
            const float beside[] = {face,
                                    std::nextafter(face, 0.0f),
                                    std::nextafter(face, 2.0f),
                                    face - 0.4f * steps.x,
                                    face + 0.4f * steps.x,
                                    face - 0.1f,
                                    face + 0.1f};
            return beside[random() % std::size(beside)];
        };
        for (std::size_t i = 0; i < rows.count; ++i) {
            Particle<float> q = particle_at(rows, i);
            const auto side = [&](float a, float b) { return near(random() % 2 ? a : b); };
            q.x = {side(low.x, high.x), side(low.y, high.y), side(low.z, high.z)};
            set_particle(rows, i, q);
        }
        rows.gaussians[0].x = {near(low.x), near(high.y), near(low.z)};
        EXPECT_THROW(solver->replace(solver->config(), rows), std::invalid_argument);
        const ClayRows now = quantised(rows, steps);
        solver->replace(solver->config(), now);
        EXPECT_TRUE(same_rows(solver->rows(*solver->snapshot()), now));
        // One that was between the walls is less than a step away.
        for (std::size_t i = 0; i < rows.count; ++i)
            for (std::size_t p = 0; p < 3; ++p) {
                const float at = rows.planes[p * rows.count + i],
                            a = p == 0   ? low.x
                                : p == 1 ? low.y
                                         : low.z,
                            b = p == 0   ? high.x
                                : p == 1 ? high.y
                                         : high.z;
                if (at < a || at > b) continue;
                EXPECT_LT(std::fabs(now.planes[p * rows.count + i] - at), 1.01f * steps.x);
            }
    }
}

TEST(Quantisation, RoundedRowsTakeFewBytesAndComeBackToTheBit)
{
    std::mt19937 random(6);
    const Quantisation steps = steps_of_three();
    for (const std::size_t particles : {0, 1, 1025, 5000})
        for (const std::size_t gaussians : {0, 3, 1500}) {
            const ClayRows a = quantised(some_clay(random, particles, gaussians), steps);
            ClayRows b = some_clay(random, particles, gaussians);
            b.object = a.object;
            for (std::size_t i = 0; i < gaussians; ++i)
                b.gaussians[i].object = a.gaussians[i].object;
            const ClayRows exact = b;
            b = quantised(b, steps);
            // Also to rows that are not rounded, and to those of other steps.
            const ClayRows other =
                quantised(exact, steps_of(0.02, {0.02, 0.02, 0.02}, {0.9, 0.9, 0.9}));
            for (const ClayRows* to :
                 std::initializer_list<const ClayRows*>{&b, &exact, &other, &a}) {
                const std::string bytes = difference(a, *to, &steps);
                ClayRows rows = a;
                apply_difference(rows, bytes);
                EXPECT_TRUE(same_rows(rows, *to));
                apply_difference(rows, bytes);
                EXPECT_TRUE(same_rows(rows, a));
                EXPECT_TRUE(same_rows(decoded(encoded(*to, &steps)), *to));
            }
            if (particles < 5000) continue;
            EXPECT_LT(encoded(b, &steps).size(), encoded(b).size());
            EXPECT_LT(difference(a, b, &steps).size(), 0.8 * double(difference(a, b).size()));
            EXPECT_LT(difference(a, b, &steps).size(), 0.7 * double(difference(a, exact).size()));
        }
}

}  // namespace
}  // namespace knead
