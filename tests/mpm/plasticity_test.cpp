// Return maps: the stress they leave lies on the yield surface, whatever the elasticity, and what
// they must not touch (volume, axes, elastic strains) they do not touch.
#include "cuda/mpm/plasticity.h"

#include <algorithm>
#include <cmath>

#include "tests/solver/clay.h"

namespace knead {
namespace {

template <class R>
class PlasticityTest : public ::testing::Test {
};
TYPED_TEST_SUITE(PlasticityTest, Scalars);

TYPED_TEST(PlasticityTest, ElasticStrainsStayToTheBit)
{
    using R = TypeParam;
    Draw draw(1);
    for (const Elasticity elasticity : elasticities)
        for (const Plasticity plasticity :
             {Plasticity::none, Plasticity::von_mises, Plasticity::herschel_bulkley,
              Plasticity::clamp, Plasticity::drucker_prager})
            for (int round = 0; round < 500; ++round) {
                if (!go_together(elasticity, plasticity)) continue;
                const Material<R> m = clay<R>(elasticity, plasticity);
                Particle<R> q = strained_by<R>(draw.strain(0.001));
                if (plasticity == Plasticity::drucker_prager)
                    q.e = q.e + isotropic(R(-0.05));
                else
                    q.k = R(draw.in(0, 0.2));
                const Particle<R> before = q;
                EXPECT_FALSE(yield(q, m, R(1e-4)));
                EXPECT_TRUE(same(q.e, before.e));
                EXPECT_EQ(q.k, before.k);
            }
}

TYPED_TEST(PlasticityTest, VonMisesLeavesTheStressOnTheYieldSurfaceAndTheVolumeAsItWas)
{
    using R = TypeParam;
    Draw draw(2);
    for (const Elasticity elasticity : yielding)
        for (const double reach : {0.1, 0.3}) {
            int return_magnitude = 0;
            for (int round = 0; round < 2000; ++round) {
                const Material<R> m = clay<R>(elasticity, Plasticity::von_mises);
                Particle<R> q = strained_by<R>(draw.strain(reach));
                const double trial = shear(q, m), volume = ln_J(q);
                const bool yielded = yield(q, m, R(1e-4));
                EXPECT_EQ(yielded, trial > yield_root * 5e4);
                if (!yielded) continue;
                ++return_magnitude;
                EXPECT_NEAR(shear(q, m), yield_root * 5e4, either<R>(2e-5, 1e-10) * 5e4);
                EXPECT_NEAR(ln_J(q), volume, either<R>(1e-6, 1e-13) * (1 + std::exp(-2 * volume)));
                EXPECT_GT(q.k, 0);
            }
            EXPECT_GT(return_magnitude, 500);
        }
}

TYPED_TEST(PlasticityTest, VolumeSurvivesTrialsFarBeyondTheYieldSurface)
{
    using R = TypeParam;
    Draw draw(3);
    for (const Elasticity elasticity : {Elasticity::neo_hookean, Elasticity::hencky})
        for (const Plasticity plasticity : {Plasticity::von_mises, Plasticity::herschel_bulkley})
            for (int round = 0; round < 1000; ++round) {
                Material<R> m = clay<R>(elasticity, plasticity);
                m.yield = R(draw.power(-3, 4));
                const Vec3<double> eps = draw.vector(1.5);
                Particle<R> q = strained_by<R>(from_stretch(draw.rotation(), eps));
                const double volume = ln_J(q);
                yield(q, m, R(1e-2));
                // Rounding takes of b's least value a share of its largest, or of 1 that is left
                // out.
                const double max_eps = std::max({eps.x, eps.y, eps.z, 0.0});
                const double lost = std::exp(2 * max_eps - 2 * std::min({eps.x, eps.y, eps.z})) +
                                    std::exp(-2 * volume);
                EXPECT_NEAR(ln_J(q), volume, either<R>(1e-6, 4e-15) * (1 + lost));
            }
}

TYPED_TEST(PlasticityTest, FlowKeepsTheAxesOfTheTrialStrain)
{
    using R = TypeParam;
    Draw draw(4);
    for (const Elasticity elasticity : elasticities)
        for (const Plasticity plasticity : {Plasticity::von_mises, Plasticity::drucker_prager,
                                            Plasticity::clamp, Plasticity::herschel_bulkley}) {
            for (int round = 0; round < 300; ++round) {
                if (!go_together(elasticity, plasticity)) continue;
                const Material<R> m = clay<R>(elasticity, plasticity);
                Particle<R> q = strained_by<R>(draw.strain(0.2));
                const Mat3<double> before = full(cast<double>(q.e));
                yield(q, m, R(1e-4));
                const Mat3<double> after = full(cast<double>(q.e));
                EXPECT_LT(size(before * after - after * before), either<R>(1e-6, 1e-14));
            }
        }
}

// Snow moves its axes one after the other: tests/mpm/return_map_test.cpp.
TYPED_TEST(PlasticityTest, YieldingTwiceIsYieldingOnce)
{
    using R = TypeParam;
    Draw draw(5);
    for (const Elasticity elasticity : elasticities)
        for (const Plasticity plasticity :
             {Plasticity::von_mises, Plasticity::drucker_prager, Plasticity::fluid})
            for (int round = 0; round < 300; ++round) {
                if (!go_together(elasticity, plasticity)) continue;
                const Material<R> m = clay<R>(elasticity, plasticity);
                Particle<R> q = strained_by<R>(draw.strain(0.2));
                yield(q, m, R(1e-4));
                const Particle<R> once = q;
                if (plasticity == Plasticity::drucker_prager)
                    q.k = 0;  // a correction may still be owed
                yield(q, m, R(1e-4));
                EXPECT_LT(size(cast<double>(q.e) - cast<double>(once.e)), either<R>(5e-6, 1e-10));
            }
}

TYPED_TEST(PlasticityTest, ReturnMapsTurnWithTheFrame)
{
    using R = TypeParam;
    Draw draw(6);
    for (const Elasticity elasticity : elasticities)
        for (const Plasticity plasticity : plasticities)
            for (int round = 0; round < 300; ++round) {
                if (!go_together(elasticity, plasticity)) continue;
                Material<R> m = clay<R>(elasticity, plasticity);
                m.hardening = 1e5;
                const Mat3<double> Q = draw.rotation();
                const Sym3<double> e = draw.strain(0.2);
                Particle<R> one = strained_by<R>(e), other = strained_by<R>(turned(Q, e));
                yield(one, m, R(1e-4)), yield(other, m, R(1e-4));
                EXPECT_LT(size(turned(Q, cast<double>(one.e)) - cast<double>(other.e)),
                          either<R>(1e-5, 1e-10));
                EXPECT_NEAR(double(one.k), double(other.k), either<R>(1e-5, 1e-10));
            }
}

// Test 12: uniaxial, pure shear and hydrostatic trials have closed forms in Hencky strain.
TYPED_TEST(PlasticityTest, HenckyVonMisesFollowsTheClosedFormWithHardeningAndSoftening)
{
    using R = TypeParam;
    Draw draw(7);
    const Vec3<double> paths[] = {
        {1, -0.5, -0.5}, {1, 0, 0}, {1, -1, 0}, {-1, 0.5, 0.5}, {0.7, 0.7, -0.3}};
    for (const double hardening : {0.0, 2e5, 2e6, -1e5})
        for (const Vec3<double>& path : paths) {
            Material<R> m = clay<R>(Elasticity::hencky, Plasticity::von_mises);
            m.hardening = R(hardening), m.yield_floor = 2e4;
            Particle<R> q{};
            double k = 0, trial_shear = 0;
            const Mat3<double> axes = draw.rotation();
            const double mean = (path.x + path.y + path.z) / 3;
            const Vec3<double> away = path - Vec3<double>{mean, mean, mean};
            Vec3<double> kept{};  // elastic Hencky deviator
            for (int step = 1; step <= 10; ++step) {
                // Each step stretches the elastic strain that the last one kept along the path.
                kept = kept + 0.03 * away;
                trial_shear = 2 * double(m.mu) * length(kept);
                const double bound = yield_root * std::max(5e4 + hardening * k, 2e4);
                if (trial_shear > bound) {
                    const double slope = bound > yield_root * 2e4 ? hardening : 0;
                    double slip = (trial_shear - bound) / (2 * double(m.mu) + 2.0 / 3 * slope);
                    if (trial_shear - 2 * double(m.mu) * slip < yield_root * 2e4)
                        slip = (trial_shear - yield_root * 2e4) / (2 * double(m.mu));
                    kept = ((trial_shear - 2 * double(m.mu) * slip) / trial_shear) * kept;
                    k += yield_root * slip;
                }
                const double volume = 0.03 * mean * step;
                const Sym3<double> was = cast<double>(q.e);
                const Vec3<double> up{std::exp(0.03 * path.x), std::exp(0.03 * path.y),
                                      std::exp(0.03 * path.z)};
                const Mat3<double> A = full(composed(axes, up));
                q.e = cast<R>(symmetric(A * (full(was) + diagonal(1.0)) * A - diagonal(1.0)));
                yield(q, m, R(1e-4));
                const Sym3<double> expected =
                    from_stretch(axes, kept + Vec3<double>{volume, volume, volume});
                EXPECT_LT(size(cast<double>(q.e) - expected), either<R>(1e-5, 1e-12));
                EXPECT_NEAR(double(q.k), k, either<R>(2e-5, 1e-12));
            }
            EXPECT_GT(k, 0.05);
        }
}

TYPED_TEST(PlasticityTest, HardeningAndSofteningKeepTheStressOnTheMovingYieldSurface)
{
    using R = TypeParam;
    Draw draw(8);
    for (const Elasticity elasticity : yielding)
        for (const double hardening : {0.0, 2e5, 2e6, -1e5, -3e5})
            for (int round = 0; round < 200; ++round) {
                Material<R> m = clay<R>(elasticity, Plasticity::von_mises);
                m.hardening = R(hardening), m.yield_floor = 1e4;
                Particle<R> q{};
                double k = 0;
                for (int step = 0; step < 6; ++step) {
                    const Mat3<double> A = diagonal(1.0) + draw.matrix(0.05);
                    q.e = cast<R>(
                        symmetric(A * (full(cast<double>(q.e)) + diagonal(1.0)) * transpose(A) -
                                  diagonal(1.0)));
                    const bool yielded = yield(q, m, R(1e-4));
                    EXPECT_GE(double(q.k), k);
                    k = double(q.k);
                    const double bound = yield_root * std::max(5e4 + hardening * k, 1e4);
                    EXPECT_LT(shear(q, m), bound + either<R>(3e-5, 1e-10) * 5e4);
                    if (yielded) {
                        EXPECT_NEAR(shear(q, m), bound, either<R>(3e-5, 1e-10) * 5e4);
                    }
                }
            }
}

TYPED_TEST(PlasticityTest, SnapBackSofteningFallsNoLowerThanTheFloor)
{
    using R = TypeParam;
    Draw draw(9);
    for (const Elasticity elasticity : yielding)
        for (int round = 0; round < 500; ++round) {
            Material<R> m = clay<R>(elasticity, Plasticity::von_mises);
            m.hardening = R(-draw.power(5, 9)), m.yield_floor = 1e4;
            Particle<R> q = strained_by<R>(draw.strain(0.2));
            const double trial = shear(q, m);
            if (!yield(q, m, R(1e-4))) continue;
            EXPECT_GE(shear(q, m), yield_root * 1e4 - either<R>(1, 1e-5));
            EXPECT_LE(shear(q, m), trial);
            EXPECT_TRUE(std::isfinite(q.k));
        }
}

TYPED_TEST(PlasticityTest, HydrostaticStrainNeverYieldsMetalOrPaste)
{
    using R = TypeParam;
    for (const Elasticity elasticity : yielding)
        for (const Plasticity plasticity : {Plasticity::von_mises, Plasticity::herschel_bulkley})
            for (const double e : {-0.9, -0.3, 0.5, 5.0}) {
                Particle<R> q = strained_by<R>(isotropic(e));
                EXPECT_FALSE(yield(q, clay<R>(elasticity, plasticity), R(1e-4)));
            }
}

TYPED_TEST(PlasticityTest, TinyStrainsOfATinyYieldStressKeepTheirDigits)
{
    using R = TypeParam;
    Draw draw(10);
    for (const Elasticity elasticity : yielding)
        for (int round = 0; round < 300; ++round) {
            Material<R> m = clay<R>(elasticity, Plasticity::von_mises);
            m.yield = R(1e-3);
            Particle<R> q = strained_by<R>(draw.strain(1e-7));
            const double volume = ln_J(q);
            if (!yield(q, m, R(1e-4))) continue;
            // The strain that stays is a hundredth of the mean that it is stored with.
            EXPECT_NEAR(shear(q, m), yield_root * 1e-3, either<R>(2e-4, 1e-9) * 1e-3);
            EXPECT_NEAR(ln_J(q), volume, 1e-7 * either<R>(1e-6, 1e-12));
        }
}

TYPED_TEST(PlasticityTest, PlasticFlowDissipatesAndNeverStoresEnergy)
{
    using R = TypeParam;
    Draw draw(18);
    for (int round = 0; round < 2000; ++round) {
        const Plasticity plasticity =
            round % 2 ? Plasticity::von_mises : Plasticity::herschel_bulkley;
        const Material<R> m = clay<R>(Elasticity::hencky, plasticity);
        const auto energy = [&](const Particle<R>& q) {
            const Vec3<double> eps = hencky(eigen(cast<double>(q.e)).value);
            const double sum = eps.x + eps.y + eps.z;
            return double(m.mu) * dot(eps, eps) + double(m.lambda) / 2 * sum * sum;
        };
        Particle<R> q = strained_by<R>(draw.strain(0.2));
        const double before = energy(q);
        yield(q, m, R(1e-4));
        EXPECT_LE(energy(q), before + either<R>(0.1, 1e-8));
    }
}

// Test 21. What rounding and violence can make of a strain: any rank, repeated values, scales of
// 1e-6 to 1e6, and left Cauchy-Green tensors that are no longer positive.
TYPED_TEST(PlasticityTest, NoTrialStrainHoweverAbsurdGivesANan)
{
    using R = TypeParam;
    Draw draw(19);
    for (int round = 0; round < 20000; ++round) {
        Material<R> m = clay<R>(elasticities[round % 3], plasticities[draw.below(6)]);
        if (!go_together(m.elasticity, m.plasticity)) continue;
        m.hardening = R(draw.below(3) - 1) * R(1e5);
        m.exponent = R(draw.in(0.2, 2)), m.cohesion = R(0.01) * R(draw.below(2));
        const auto value = [&] {  // of b
            const double any[] = {0, 1, 1e-6, 1e6, -1e-6, draw.power(-12, 6), draw.power(-1, 1)};
            return any[draw.below(7)];
        };
        const double first = value(), second = draw.below(3) ? value() : first;
        const Vec3<double> b{first, second, draw.below(3) ? value() : second};
        Particle<R> q = strained_by<R>(composed(draw.rotation(), b - Vec3<double>{1, 1, 1}));
        q.k = R(draw.in(-0.5, 0.5));
        const Sym3<R> trial = q.e;
        yield(q, m, R(1e-4));
        ASSERT_TRUE(finite(q.e) && std::isfinite(q.k))
            << int(m.elasticity) << ' ' << int(m.plasticity) << ' ' << b.x << ' ' << b.y << ' '
            << b.z;
        ASSERT_TRUE(finite(kirchhoff_stress(q, m)));
        // Nor does a map make a strain much larger than what it was given.
        EXPECT_LE(size(cast<double>(q.e)), 4 * size(cast<double>(trial)) + 2)
            << int(m.elasticity) << ' ' << int(m.plasticity) << ' ' << b.x << ' ' << b.y << ' '
            << b.z;
    }
}

// A state however far strained, crushed to nothing or drawn out to a thread, and what is no state
// at all: eigenvalues of b that rounding left at or below 0.
TYPED_TEST(PlasticityTest, NeoHookeanFlowObeysItsLawAndDissipatesHoweverFarTheTrial)
{
    using R = TypeParam;
    Draw draw(20);
    const double dt = 1e-4;
    int of_no_strain = 0;
    for (int round = 0; round < 60000; ++round) {
        const bool paste = round % 2 > 0;
        Material<R> m = clay<R>(Elasticity::neo_hookean,
                                paste ? Plasticity::herschel_bulkley : Plasticity::von_mises);
        m.yield = R(draw.power(2, 5.7)), m.viscosity = R(draw.power(0, 5));
        m.exponent = R(draw.in(0.2, 2));
        const bool absurd = draw.below(4) == 0;
        const auto value = [&] {  // of b
            if (!absurd) return draw.power(-6, 6);
            const double any[] = {0, 1, -1e-6, 1e6, -draw.power(-3, 2), draw.power(-12, 6)};
            return any[draw.below(6)];
        };
        const Vec3<double> b{value(), value(), value()};
        Particle<R> q = strained_by<R>(composed(draw.rotation(), b - Vec3<double>{1, 1, 1}));
        const Particle<R> trial = q;
        if (!yield(q, m, R(dt))) continue;
        of_no_strain += b.x + b.y + b.z <= 0;
        ASSERT_TRUE(finite(q.e) && std::isfinite(q.k)) << b.x << ' ' << b.y << ' ' << b.z;
        const double slip = double(q.k) / yield_root;
        double law = yield_root * double(m.yield);
        if (paste)
            law += std::sqrt(2.0) * double(m.viscosity) *
                   std::pow(std::sqrt(2.0) * slip / dt, double(m.exponent));
        EXPECT_GT(slip, 0);
        // Rounding e, of order one or as large as the trial, moves the stress by a share of this.
        const double rounded = either<R>(1e-6, 1e-14) * (shear(trial, m) + double(m.mu));
        EXPECT_NEAR(shear(q, m), law, either<R>(1e-3, 1e-9) * law + rounded)
            << b.x << ' ' << b.y << ' ' << b.z;
        // And the volume is that of a state only where its values are neither far apart nor small.
        const double low = std::min({b.x, b.y, b.z}), high = std::max({b.x, b.y, b.z, 1.0});
        if (!(low > either<R>(1e-2, 1e-6) * high)) continue;
        if (b.x * b.y * b.z < either<R>(1e-2, 2e-6)) continue;
        const auto energy = [&](const Particle<R>& p) {
            return double(m.mu) / 2 * (trace(cast<double>(p.e)) - 2 * ln_J(p)) +
                   double(m.lambda) / 2 * ln_J(p) * ln_J(p);
        };
        EXPECT_LE(energy(q), energy(trial) + either<R>(1e-4, 1e-9) * (energy(trial) + double(m.mu)))
            << b.x << ' ' << b.y << ' ' << b.z;
    }
    EXPECT_GT(of_no_strain, 1000);
}

}  // namespace
}  // namespace knead
