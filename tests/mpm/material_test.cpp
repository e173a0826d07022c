// Stress against the derivative of the stored energy, in every frame, and down to the strains at
// which a float loses an identity that is stored with them.
#include "cuda/mpm/material.h"

#include <algorithm>
#include <cmath>

#include "tests/solver/samples.h"

namespace knead {
namespace {

template <class R>
class MaterialTest : public ::testing::Test {
};
TYPED_TEST_SUITE(MaterialTest, Scalars);

constexpr Elasticity elasticities[] = {Elasticity::neo_hookean, Elasticity::fixed_corotated,
                                       Elasticity::hencky};

// E = 1 MPa, nu = 0.3
template <class R>
Material<R> solid(Elasticity elasticity)
{
    Material<R> m{};
    m.elasticity = elasticity;
    m.plasticity = Plasticity::none;
    m.density = 1000;
    m.mu = R(1e6 / 2.6);
    m.lambda = R(0.3e6 / (1.3 * 0.4));
    m.mass = m.volume = 1;
    return m;
}

template <class R>
Particle<R> strained_by(const Sym3<R>& e)
{
    Particle<R> q{};
    q.e = e;
    return q;
}

// Energy per rest volume [J/m^3] at principal stretches s: for the oracle, from its definition.
double energy(const Material<double>& m, Vec3<double> s)
{
    const double J = s.x * s.y * s.z, ln_J = std::log(J);
    const auto each = [&](auto f) { return f(s.x) + f(s.y) + f(s.z); };
    switch (m.elasticity) {
        case Elasticity::neo_hookean:
            return m.mu / 2 * (each([](double t) { return t * t; }) - 3) - m.mu * ln_J +
                   m.lambda / 2 * ln_J * ln_J;
        case Elasticity::fixed_corotated:
            return m.mu * each([](double t) { return (t - 1) * (t - 1); }) +
                   m.lambda / 2 * (J - 1) * (J - 1);
        case Elasticity::hencky:
            return m.mu * each([](double t) { return std::log(t) * std::log(t); }) +
                   m.lambda / 2 * ln_J * ln_J;
    }
    return 0;
}

double energy(const Material<double>& m, const Sym3<double>& e)
{
    const Vec3<double> b = eigen(e).value;
    return energy(m, Vec3<double>{std::sqrt(1 + b.x), std::sqrt(1 + b.y), std::sqrt(1 + b.z)});
}

// Strain after a further velocity gradient L for unit time: (I + L) b (I + L)^T - I.
Sym3<double> moved(const Sym3<double>& e, const Mat3<double>& L)
{
    const Mat3<double> A = diagonal(1.0) + L;
    return symmetric(A * (full(e) + diagonal(1.0)) * transpose(A) - diagonal(1.0));
}

TYPED_TEST(MaterialTest, StressDoesTheWorkThatTheEnergyStores)
{
    using R = TypeParam;
    Draw draw(1);
    for (const Elasticity elasticity : elasticities)
        for (int round = 0; round < 500; ++round) {
            const Sym3<R> e = cast<R>(draw.strain(0.3));
            const Material<double> exact = solid<double>(elasticity);
            const Sym3<double> tau =
                cast<double>(kirchhoff_stress(strained_by(e), solid<R>(elasticity)));
            const Mat3<double> L = draw.matrix(), D = full(symmetric(L)), T = full(tau);
            const double power = dot(T.a, D.a) + dot(T.b, D.b) + dot(T.c, D.c), h = 1e-5;
            const double rise = (energy(exact, moved(cast<double>(e), h * L)) -
                                 energy(exact, moved(cast<double>(e), -h * L))) /
                                (2 * h);
            EXPECT_NEAR(power, rise, either<R>(1e-5, 1e-8) * (exact.lambda + size(tau)) * size(L));
        }
}

TYPED_TEST(MaterialTest, StressMatchesItsPrincipalValues)
{
    using R = TypeParam;
    Draw draw(2);
    for (const Elasticity elasticity : elasticities)
        for (int round = 0; round < 1000; ++round) {
            const Material<R> m = solid<R>(elasticity);
            const Mat3<double> Q = draw.rotation();
            const Vec3<double> eps = draw.vector(0.8);
            const auto strain = [](double s) { return std::expm1(2 * s); };
            const Sym3<double> e = composed(Q, {strain(eps.x), strain(eps.y), strain(eps.z)});
            const Sym3<double> expected =
                composed(Q, principal_stress(solid<double>(elasticity), 0.0, eps));
            const Sym3<R> found = kirchhoff_stress(strained_by(cast<R>(e)), m);
            EXPECT_LT(size(cast<double>(found) - expected),
                      either<R>(1e-5, 1e-13) * (size(expected) + double(m.lambda)));
            const Sym3<R> composed_again =
                composed(cast<R>(Q), principal_stress(m, R(0), cast<R>(eps)));
            EXPECT_LT(size(cast<double>(composed_again) - expected),
                      either<R>(1e-5, 1e-13) * (size(expected) + double(m.lambda)));
        }
}

TYPED_TEST(MaterialTest, StressTurnsWithTheFrame)
{
    using R = TypeParam;
    Draw draw(3);
    Material<R> fluid = solid<R>(Elasticity::neo_hookean);
    fluid.plasticity = Plasticity::fluid, fluid.bulk = 1e5, fluid.exponent = 7,
    fluid.viscosity = 20;
    for (int round = 0; round < 2000; ++round) {
        const Material<R> m = round % 4 == 3 ? fluid : solid<R>(elasticities[round % 4]);
        const Mat3<double> Q = draw.rotation(), C = draw.matrix(10);
        const Sym3<double> e = draw.strain(0.3);
        Particle<R> one = strained_by(cast<R>(e)), other = strained_by(cast<R>(turned(Q, e)));
        one.C = cast<R>(C), other.C = cast<R>(Q * C * transpose(Q));
        const Sym3<double> expected = turned(Q, cast<double>(kirchhoff_stress(one, m)));
        const Sym3<double> found = cast<double>(kirchhoff_stress(other, m));
        EXPECT_LT(size(found - expected),
                  either<R>(2e-5, 1e-13) * (double(m.lambda) + size(expected)));
    }
}

TYPED_TEST(MaterialTest, AtRestThereIsExactlyNoStress)
{
    using R = TypeParam;
    for (const Elasticity elasticity : elasticities)
        EXPECT_EQ(size(kirchhoff_stress(strained_by(Sym3<R>{}), solid<R>(elasticity))), 0);
}

TYPED_TEST(MaterialTest, SmallStrainsFollowHookesLawWithAllTheirDigits)
{
    using R = TypeParam;
    Draw draw(4);
    for (const Elasticity elasticity : elasticities)
        for (const double scale : {1e-7, 1e-12}) {
            const Material<R> m = solid<R>(elasticity);
            const Sym3<R> e = cast<R>(scale * symmetric(draw.matrix()));  // twice the small strain
            const Sym3<double> found = cast<double>(kirchhoff_stress(strained_by(e), m));
            const Sym3<double> strain = 0.5 * cast<double>(e);
            const Sym3<double> hooke =
                2 * double(m.mu) * strain + isotropic(double(m.lambda) * trace(strain));
            EXPECT_LT(size(found - hooke), (either<R>(1e-6, 1e-14) + 3 * scale) * size(hooke));
        }
}

TYPED_TEST(MaterialTest, VolumeIsReadWithoutCancellation)
{
    using R = TypeParam;
    Draw draw(5);
    for (int round = 0; round < 1000; ++round) {
        const double eps = (draw.below(2) ? 1 : -1) * draw.power(-12, 0);
        const R found = log_volume(determinant_excess(isotropic(R(std::expm1(2 * eps)))));
        const double crushed = std::max(0.0, std::expm1(-6 * eps));  // J^2 nears the rounding of 1
        EXPECT_NEAR(double(found), 3 * eps,
                    either<R>(1e-6, 4e-15) * std::abs(3 * eps) + either<R>(2e-7, 4e-16) * crushed);
    }
    EXPECT_TRUE(std::isfinite(log_volume(R(-1))));
    EXPECT_TRUE(std::isfinite(log_volume(R(-5))));
    EXPECT_TRUE(std::isnan(log_volume(std::numeric_limits<R>::quiet_NaN())));
}

TYPED_TEST(MaterialTest, CrushedAndOverstretchedParticlesHaveFiniteStressThatResists)
{
    using R = TypeParam;
    for (const Elasticity elasticity : elasticities) {
        const Material<R> m = solid<R>(elasticity);
        for (const R e : {R(-1), R(-0.999999), R(-1.5), R(1e6)})
            EXPECT_TRUE(finite(kirchhoff_stress(strained_by(isotropic(e)), m)));
        EXPECT_LE(trace(kirchhoff_stress(strained_by(isotropic(R(-0.9))), m)), 0);
        EXPECT_GT(trace(kirchhoff_stress(strained_by(isotropic(R(3))), m)), 0);
    }
}

TYPED_TEST(MaterialTest, AFluidFeelsOnlyPressureAndTheRateOfShear)
{
    using R = TypeParam;
    Draw draw(6);
    Material<R> m = solid<R>(Elasticity::neo_hookean);
    m.plasticity = Plasticity::fluid, m.bulk = 2e6, m.exponent = 7, m.viscosity = 20;
    for (int round = 0; round < 1000; ++round) {
        const double ln_J = draw.in(-0.1, 0.1), J = std::exp(ln_J);
        Particle<R> q = strained_by(isotropic(R(std::expm1(2 * ln_J / 3))));
        q.C = cast<R>(draw.matrix(100));
        const Sym3<double> tau = cast<double>(kirchhoff_stress(q, m));
        const double pressure = 2e6 / 7 * (std::pow(J, -7) - 1);
        EXPECT_NEAR(trace(tau) / 3, -pressure * J, either<R>(5e-6, 1e-13) * 2e6);
        const Sym3<double> shear = (2 * 20 * J) * deviator(symmetric(cast<double>(q.C)));
        EXPECT_LT(size(deviator(tau) - shear), either<R>(1e-6, 1e-13) * (size(shear) + 2e6));
        const Mat3<double> W = skew(cast<double>(q.C));  // a spin alone does nothing
        q.C = cast<R>(W);
        EXPECT_LT(size(deviator(cast<double>(kirchhoff_stress(q, m)))),
                  either<R>(1e-6, 1e-13) * 2e6);
    }
}

// Where J^-6 reaches 32 the law of pressure goes on as its own tangent: continuous, with its slope,
// and no stiffer however far it is pressed.
TYPED_TEST(MaterialTest, AFluidStiffensUntilSubstepsAreCutNoShorterForIt)
{
    using R = TypeParam;
    Material<R> m = solid<R>(Elasticity::neo_hookean);
    m.plasticity = Plasticity::fluid, m.bulk = 2e6, m.exponent = 7, m.viscosity = 0;
    m.density = 1000;
    const auto pressed = [](double ln_J) {
        return strained_by(isotropic(R(std::expm1(2 * ln_J / 3))));
    };
    const auto pressure = [&](double ln_J) {
        return -double(trace(kirchhoff_stress(pressed(ln_J), m))) / 3;
    };
    const double last = -std::log(32) / 6, at_last = 2e6 / 7 * std::expm1(-7 * last);
    EXPECT_NEAR(pressure(last + 1e-3), at_last * std::exp(last), 0.01 * at_last);
    EXPECT_NEAR(pressure(last - 1e-3), pressure(last + 1e-3), 0.02 * at_last);
    const double slope = 2e6 * (6.0 / 7 * 32 + std::exp(last) / 7);
    EXPECT_NEAR((pressure(-2) - pressure(-1)) / slope, 1, either<R>(1e-3, 1e-9));
    EXPECT_NEAR(3 * slope / 1000 / double(stiffness(pressed(-3), m)), 1, either<R>(1e-5, 1e-12));
    EXPECT_LE(double(stiffness(pressed(-3), m)), 32 * double(stiffness(pressed(0), m)));
    m.exponent = 1;  // does not stiffen
    EXPECT_NEAR(pressure(-3), 2e6 * (1 - std::exp(-3)), either<R>(1e-3, 1e-9) * 2e6);
}

TYPED_TEST(MaterialTest, SnowHardensAsItIsPackedAndOthersDoNot)
{
    using R = TypeParam;
    Material<R> m = solid<R>(Elasticity::fixed_corotated);
    m.snow = 10;
    EXPECT_EQ(snow_hardening(m, R(-0.1)), 1);
    m.plasticity = Plasticity::clamp;
    EXPECT_EQ(snow_hardening(m, R(0)), 1);
    EXPECT_NEAR(double(snow_hardening(m, R(std::log(0.9)))), std::exp(10 * 0.1), 1e-5);
    EXPECT_GT(snow_hardening(m, R(-0.2)), snow_hardening(m, R(-0.1)));
    EXPECT_LT(snow_hardening(m, R(0.2)), 1);
    for (const R k : {R(-1), R(1), R(-100), R(100)}) {
        EXPECT_GE(snow_hardening(m, k), R(0.05));
        EXPECT_LE(snow_hardening(m, k), R(20));
    }
    // Stress is proportional to the factor, for every elasticity.
    Draw draw(7);
    for (const Elasticity elasticity : elasticities) {
        m.elasticity = elasticity;
        Particle<R> q = strained_by(cast<R>(draw.strain(0.1)));
        const Sym3<R> loose = kirchhoff_stress(q, m);
        q.k = R(-0.1);
        const Sym3<R> tight = kirchhoff_stress(q, m);
        EXPECT_LT(size(tight - snow_hardening(m, q.k) * loose),
                  R(either<R>(1e-5, 1e-13)) * size(tight));
    }
}

TYPED_TEST(MaterialTest, SoundSpeedIsTheLongitudinalWaves)
{
    using R = TypeParam;
    Material<R> m = solid<R>(Elasticity::hencky);
    // sqrt((K + 4/3 G) / rho) = sqrt(E (1 - nu) / ((1 + nu) (1 - 2 nu) rho))
    EXPECT_NEAR(double(sound_speed(m)), std::sqrt(1e6 * 0.7 / (1.3 * 0.4) / 1000), 1e-4);
    m.plasticity = Plasticity::fluid, m.bulk = 1e5;
    EXPECT_NEAR(double(sound_speed(m)), 10, 1e-5);
}

}  // namespace
}  // namespace knead
