// accuracy: stresses and return maps on random states, against the oracle's laws.
#include <fmt/format.h>

#include <algorithm>

#include "cuda/mpm/plasticity.h"
#include "host/verify/oracle.h"
#include "host/verify/verify.h"

namespace knead {
namespace {

const std::pair<Elasticity, const char*> elasticities[] = {
    {Elasticity::neo_hookean, "neo-Hookean"},
    {Elasticity::fixed_corotated, "fixed corotated"},
    {Elasticity::hencky, "Hencky"}};

template <class R>
const char* scalar = sizeof(R) == 4 ? "float" : "double";

// Rounded to R, so that oracle and code get the same numbers.
template <class R>
Sym3<R> rounded(const Sym3<double>& e)
{
    return {R(e.xx), R(e.yy), R(e.zz), R(e.xy), R(e.xz), R(e.yz)};
}
template <class R>
Sym3<double> in_double(const Sym3<R>& e)
{
    return {double(e.xx), double(e.yy), double(e.zz), double(e.xy), double(e.xz), double(e.yz)};
}

Material<double> clay(Elasticity elasticity, Plasticity plasticity)
{
    Material<double> m{};
    m.elasticity = elasticity, m.plasticity = plasticity;
    m.density = 1000;
    m.mu = 1e6 / 2.6, m.lambda = 0.3e6 / (1.3 * 0.4);  // E = 1 MPa, nu = 0.3
    m.bulk = 1e6;
    m.yield = 5e4;
    m.friction = 0.6;
    m.compress = 0.025, m.stretch = 0.0075, m.snow = 10;
    m.viscosity = 100, m.exponent = 0.6;
    m.mass = m.volume = 1;
    return m;
}

template <class R>
void stresses(Verification& v, int states)
{
    oracle::Draw draw(1);
    for (const auto& [elasticity, name] : elasticities) {
        const auto m = cast<R>(clay(elasticity, Plasticity::none));
        double worst = 0;
        for (int i = 0; i < states; ++i) {
            Particle<R> q{};
            q.e = rounded<R>(draw.strain(0.7, 1.4));
            const Sym3<double> tau = in_double(kirchhoff_stress(q, m)),
                               true_tau = oracle::solid(cast<double>(m), in_double(q.e)).tau;
            const double off =
                std::sqrt(norm_squared(tau + -1.0 * true_tau) / norm_squared(true_tau));
            worst = off > worst || !(off == off) ? off : worst;
        }
        v.add(at_most(fmt::format("stress, {}, {}: relative error", name, scalar<R>), worst,
                      sizeof(R) == 4 ? 2e-5 : 1e-11, "",
                      "strains or stiffness beyond what this precision holds: use the reference"));
    }
}

// A plastic flow law and its tested properties.
struct Law {
    const char* name;
    Plasticity plasticity;
    double hardening = 0, cohesion = 0;
    bool surface = true;     // the stress must lie on a yield surface
    bool remembers = false;  // k is a logarithmic volume, counted with that of the clay
};
const Law laws[] = {{"von Mises", Plasticity::von_mises},
                    {"von Mises, hardening", Plasticity::von_mises, 2e5},
                    {"Herschel-Bulkley", Plasticity::herschel_bulkley, 0, 0, false},
                    {"Drucker-Prager", Plasticity::drucker_prager, 0, 0, true, true},
                    {"Drucker-Prager, cohesive", Plasticity::drucker_prager, 0, 0.01, true, true},
                    // Energy at the hardening of the trial state: compacted snow is harder and may
                    // store more. Its bounds apply to stretches, not stresses.
                    {"snow", Plasticity::clamp, 0, 0, false, true}};

struct Worst {
    double residual = 0, volume = 0, gain = 0;
    static void raise(double& worst, double x)
    {
        if (x > worst || !(x == x)) worst = x;
    }
};

double off_surface(const Law& law, const Material<double>& m, const Sym3<double>& tau, double k,
                   bool yielded)
{
    if (law.plasticity == Plasticity::von_mises) {
        const double bound = std::sqrt(2.0 / 3) * (m.yield + m.hardening * k);
        const double off = oracle::shear(tau) / bound - 1;
        return yielded ? std::fabs(off) : std::max(off, 0.0);
    }
    const double tip = (m.lambda + 2 * m.mu / 3) * m.cohesion;
    const double bound = oracle::cone(tau, m.friction) * std::max(oracle::pressure(tau) + tip, 0.0);
    return std::max(oracle::shear(tau) - bound, 0.0) / m.mu;
}

template <class R>
Worst returned(const Law& law, Elasticity elasticity, int states)
{
    oracle::Draw draw(2);
    Worst worst;
    Material<double> given = clay(elasticity, law.plasticity);
    given.hardening = law.hardening, given.cohesion = law.cohesion;
    const auto m = cast<R>(given);
    const auto exact = cast<double>(m);
    for (int i = 0; i < states; ++i) {
        Particle<R> q{};
        q.e = rounded<R>(draw.strain(0.7, 1.4));
        q.k = R(law.plasticity == Plasticity::clamp ? 0 : draw.in(0, 0.1));
        const double k = double(q.k);
        const oracle::StressState before = oracle::solid(exact, in_double(q.e));
        const bool yielded = yield(q, m, R(1e-4));
        const oracle::StressState after = oracle::solid(exact, in_double(q.e));
        if (law.surface)
            Worst::raise(worst.residual, off_surface(law, exact, after.tau, double(q.k), yielded));
        const double kept = law.remembers ? double(q.k) - k : 0;
        Worst::raise(worst.volume, std::fabs(after.log_J - before.log_J + kept));
        Worst::raise(worst.gain, after.energy / before.energy - 1);
    }
    return worst;
}

template <class R>
void return_maps(Verification& v, int states)
{
    for (const Law& law : laws) {
        Worst worst;  // over all elasticities
        for (const auto& [elasticity, name] : elasticities) {
            if (!go_together(elasticity, law.plasticity)) continue;
            const Worst one = returned<R>(law, elasticity, states);
            Worst::raise(worst.residual, one.residual);
            Worst::raise(worst.volume, one.volume);
            Worst::raise(worst.gain, one.gain);
        }
        const std::string title = fmt::format("{}, {}: ", law.name, scalar<R>);
        const bool single = sizeof(R) == 4;
        if (law.surface)
            v.add(at_most(title + "off the yield surface", worst.residual, single ? 2e-5 : 1e-9, "",
                          "stress is off by this share of the yield stress"));
        v.add(at_most(title + "change of ln J", worst.volume, single ? 1e-6 : 1e-12, "",
                      "watch volume.drift of the report over long kneading"));
        v.add(at_most(title + "energy gained by flow", worst.gain, 1e-6, "",
                      "watch energy in frames.csv"));
    }
}

// Liquid: against its explicit formula.
template <class R>
void liquid(Verification& v, int states)
{
    oracle::Draw draw(3);
    Material<double> given = clay(Elasticity::neo_hookean, Plasticity::fluid);
    given.exponent = 7;
    const auto m = cast<R>(given);
    double worst = 0;
    for (int i = 0; i < states; ++i) {
        Particle<R> q{};
        const double J = draw.in(0.9, 1.1);
        q.e = rounded<R>(isotropic(std::pow(J, 2.0 / 3) - 1));
        q.C = R(draw.in(-50, 50)) * outer(Vec3<R>{1, 0, 0}, Vec3<R>{0, 1, 0});
        const double b = 1 + double(q.e.xx), true_J = std::pow(b, 1.5);
        const double p = 1e6 / 7 * (std::pow(true_J, -7.0) - 1);
        const double shear = 100 * true_J * double(q.C.b.x);  // 2 eta J D_xy
        const Sym3<double> tau = in_double(kirchhoff_stress(q, m));
        const double off = std::max(std::fabs(tau.xx + p * true_J), std::fabs(tau.xy - shear));
        Worst::raise(worst, off / 1e6);
    }
    v.add(at_most(fmt::format("stress, liquid, {}: error over bulk modulus", scalar<R>), worst,
                  sizeof(R) == 4 ? 2e-6 : 1e-13, ""));
}

}  // namespace

void laws_part(Verification& v)
{
    const int states = v.quick() ? 3000 : 30000;
    stresses<double>(v, states), stresses<float>(v, states);
    liquid<double>(v, states), liquid<float>(v, states);
    return_maps<double>(v, states / 2), return_maps<float>(v, states / 2);
}

// Steady simple shear: tau = Y / sqrt(3) + K rate^n, whatever the elasticity.
void shear_part(Verification& v)
{
    for (const double n : {1.0, 0.6, 0.4}) {
        Material<double> m = clay(Elasticity::neo_hookean, Plasticity::herschel_bulkley);
        m.mu = 4e6, m.lambda = 8e6;  // stiff: steady stress is reached at small strain
        m.yield = 600, m.viscosity = 2000, m.exponent = n;
        constexpr double rate = 10, dt = 1e-5;  // [1/s] [s]
        Particle<double> q{};
        for (int i = 0; i < 1500; ++i) {  // b <- (I + dt L) b (I + dt L)^T, L = rate e_x e_y^T
            const Mat3<double> A =
                diagonal(1.0) + dt * rate * outer(Vec3<double>{1, 0, 0}, Vec3<double>{0, 1, 0});
            const Mat3<double> b = A * (full(q.e) + diagonal(1.0)) * transpose(A);
            q.e = symmetric(b - diagonal(1.0));
            yield(q, m, dt);
        }
        const double expected = m.yield / std::sqrt(3.0) + m.viscosity * std::pow(rate, n);
        v.add(near(fmt::format("Herschel-Bulkley, steady simple shear, n = {}", n),
                   kirchhoff_stress(q, m).xy, expected, 0.02 * expected, "Pa",
                   "divide the measured consistency by the ratio of the two numbers"));
    }
}

}  // namespace knead
