// A photographed object becomes clay: volumes, places, opacity and colours of what fills it.
#include "host/assets/fill.h"

#include <gtest/gtest.h>

#include <array>
#include <stdexcept>

#include "host/base/errors.h"
#include "host/base/parallel.h"
#include "tests/assets/splat_shapes.h"
#include "tests/reason.h"
#include "tests/sanitized.h"

namespace knead {
namespace {

FillOptions options_of(double cell)
{
    FillOptions options;
    options.cell = cell;
    return options;
}

TEST(Fill, ParticlesHaveTheVolumeOfTheObject)
{
    for (const SplatShape& shape :
         {ball_shape(), box_shape(), torus_shape(), bumpy_shape(), bowl_shape()}) {
        if (sanitized && shape.name != "bowl") continue;
        const FilledObject o = fill(cloud_of(shape, 8000), options_of(1.0 / 32));
        const double volume = double(o.particles.size()) * o.particle_volume;
        EXPECT_NEAR(o.particle_volume, std::pow(1.0 / 32, 3) / 8, 1e-12);
        const double bound = shape.name == "bowl" ? 0.05 : 0.03;  // its wall is five spacings thick
        EXPECT_NEAR(volume / shape.volume(), 1, bound) << shape.name;
        EXPECT_NEAR(o.report.volume / shape.volume(), 1, bound) << shape.name;
        for (Vec3<double> x : o.particles) ASSERT_LT(shape.phi(x), 0.03) << shape.name;
    }
}

TEST(Fill, ParticlesFillEveryPartAlike)
{
    const FilledObject o = fill(cloud_of(ball_shape(), 8000), options_of(1.0 / 32));
    std::array<double, 9> count{};
    for (Vec3<double> x : o.particles) {
        ++count[std::size_t((x.x > 0) + 2 * (x.y > 0) + 4 * (x.z > 0))];
        count[8] += length(x) < 0.3;
    }
    const double ball = 4 * std::numbers::pi / 3;
    for (std::size_t k = 0; k < 8; ++k)
        EXPECT_NEAR(count[k] * o.particle_volume, ball * 0.125 / 8, 0.03 * ball * 0.125 / 8) << k;
    EXPECT_NEAR(count[8] * o.particle_volume, ball * 0.027, 0.01 * ball * 0.027);
}

TEST(Fill, AThinPartGetsParticlesAllAlongIt)
{
    SplatCloud cloud = cloud_of(ball_shape(), 10000);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> uniform(-0.15, 0.15);
    std::vector<Vec3<double>> leaf;
    for (int k = 0; k < 4000; ++k) {
        leaf.push_back({0.65 + uniform(random), uniform(random), 0.001 * uniform(random)});
        cloud.centre.push_back(cast<float>(leaf.back()));
        cloud.rotation.push_back({1, 0, 0, 0});
        cloud.scale.push_back({0.006f, 0.006f, 0.001f});
        cloud.opacity.push_back(0.95f);
        cloud.sh.push_back({0, 0, 0});
    }
    const double cell = 1.0 / 32, stratum = cell / 2;
    const FilledObject o = fill(cloud, options_of(cell));
    double farthest = 0;
    for (std::size_t k = 0; k < leaf.size(); k += 20) {
        double nearest = 1;
        for (Vec3<double> x : o.particles) nearest = min(nearest, length(x - leaf[k]));
        farthest = max(farthest, nearest);
    }
    EXPECT_LT(farthest, 2.5 * stratum);
    EXPECT_GT(o.report.thin, 50u);
    // A layer one particle thick.
    EXPECT_LT(double(o.report.thin) * stratum * stratum, 1.3 * 0.3 * 0.3);
}

// Light that passes the splats below the plane z = 0 along -z, at (x, y).
double passing(const FilledObject& o, double x, double y)
{
    double passes = 1;
    for (std::size_t i = o.surface; i < o.splats.count(); ++i) {
        const Vec3<double> c = cast<double>(o.splats.centre[i]);
        const double s = o.splats.scale[i].x;
        const double d2 = (c.x - x) * (c.x - x) + (c.y - y) * (c.y - y);
        if (c.z < 0 && d2 < 9 * s * s)
            passes *= 1 - o.splats.opacity[i] * std::exp(-d2 / (2 * s * s));
    }
    return passes;
}

TEST(Fill, ACutThroughTheMiddleIsOpaque)
{
    for (std::size_t max_interior : {std::size_t(200000), std::size_t(3000)}) {
        FillOptions options = options_of(1.0 / 24);
        options.max_interior = max_interior;
        const FilledObject o = fill(cloud_of(ball_shape(), 8000), options);
        EXPECT_LE(o.splats.count() - o.surface, max_interior);
        const double rim = 0.5 - 2.5 * o.report.interior_spacing;
        double most = 0;
        for (double x = -rim; x < rim; x += 0.02)
            for (double y = -rim; y < rim; y += 0.02)
                if (std::hypot(x, y) < rim) most = max(most, passing(o, x, y));
        EXPECT_LT(most, 0.05) << max_interior;
    }
}

TEST(Fill, InnerSplatsLieTwoAndAHalfHalfAxesUnderTheSurface)
{
    for (const SplatShape& shape : {ball_shape(), torus_shape()}) {
        const FilledObject o = fill(cloud_of(shape, 8000), options_of(1.0 / 32));
        EXPECT_GT(o.splats.count(), o.surface + 1000);
        EXPECT_EQ(o.surface, 8000u);
        double least = 10;
        for (std::size_t i = o.surface; i < o.splats.count(); ++i) {
            const double depth = -shape.phi(cast<double>(o.splats.centre[i]));
            least = min(least, depth / o.splats.scale[i].x);
            EXPECT_EQ(o.splats.scale[i].x, o.splats.scale[i].z);
            EXPECT_GT(o.splats.opacity[i], 0.95f);
        }
        EXPECT_GT(least, 2) << shape.name;
    }
}

// A linear function is harmonic: its values on the surface have it as their only solution.
TEST(Fill, ColoursInsideSolveLaplacesEquation)
{
    for (const SplatShape& shape : {ball_shape(), box_shape(), bumpy_shape()}) {
        if (sanitized && shape.name != "box") continue;
        const FilledObject o = fill(cloud_of(shape, 8000), options_of(1.0 / 32));
        double worst = 0, mean = 0;
        for (std::size_t i = o.surface; i < o.splats.count(); ++i) {
            const Vec3<double> x = cast<double>(o.splats.centre[i]);
            const double e = length(cast<double>(o.splats.sh[i]) - (0.4 / shape.half) * x);
            worst = max(worst, e), mean += e;
        }
        mean /= double(o.splats.count() - o.surface);
        // The surface's colours hold for a layer about a spacing deep on both sides of it.
        const double slope = 0.4 / shape.half, spacing = o.report.grid_spacing;
        EXPECT_LT(worst, 3 * slope * spacing) << shape.name;
        EXPECT_LT(mean, 1.3 * slope * spacing) << shape.name;
    }
}

TEST(Fill, ColoursInsideStayBetweenTheSurfacesAndHaveNoDirection)
{
    SplatCloud cloud = cloud_of(bumpy_shape(), 10000);
    cloud.degree = 2;
    std::mt19937_64 random(5);
    std::uniform_real_distribution<float> uniform(-1, 1);
    cloud.sh.clear();
    for (std::size_t i = 0; i < 9 * cloud.count(); ++i)
        cloud.sh.push_back({uniform(random), 0.25f, 2 + uniform(random)});
    const FilledObject o = fill(cloud, options_of(1.0 / 24));
    ASSERT_EQ(o.splats.sh.size(), 9 * o.splats.count());
    for (std::size_t i = 0; i < o.splats.count(); ++i)
        for (std::size_t k = 0; k < 9; ++k) {
            const Vec3<float> c = o.splats.sh[9 * i + k];
            if (i < o.surface) {
                ASSERT_EQ(c.x, cloud.sh[9 * i + k].x);
            } else if (k > 0) {
                ASSERT_EQ(length(c), 0);
            } else {
                ASSERT_LE(std::abs(c.x), 1.0f);
                ASSERT_NEAR(c.y, 0.25f, 1e-5f);
                ASSERT_LE(std::abs(c.z - 2), 1.0f);
            }
        }
}

bool same(const FilledObject& a, const FilledObject& b)
{
    const auto equal = [](const auto& u, const auto& v) {
        if (u.size() != v.size()) return false;
        for (std::size_t i = 0; i < u.size(); ++i)
            if (u[i].x != v[i].x || u[i].y != v[i].y || u[i].z != v[i].z) return false;
        return true;
    };
    return equal(a.particles, b.particles) && equal(a.splats.centre, b.splats.centre) &&
           equal(a.splats.sh, b.splats.sh) && a.splats.opacity == b.splats.opacity;
}

TEST(Fill, HasTheSameBitsForAnyNumberOfThreadsAndOthersForAnotherSeed)
{
    Spoil spoil;
    spoil.floaters = 0.02;
    spoil.interior = 0.2;
    const SplatCloud cloud = cloud_of(torus_shape(), 8000, spoil);
    FillOptions options = options_of(1.0 / 24);
    const int before = loop_threads();
    set_loop_threads(1);
    const FilledObject one = fill(cloud, options);
    set_loop_threads(3);
    const FilledObject three = fill(cloud, options);
    options.seed = 2;
    const FilledObject other = fill(cloud, options);
    set_loop_threads(before);
    EXPECT_TRUE(same(one, three));
    EXPECT_FALSE(same(one, other));
    EXPECT_NEAR(double(other.particles.size()) / double(one.particles.size()), 1, 0.01);
}

TEST(Fill, RefusesRulesOutOfRangeAndMoreMemoryThanAllowed)
{
    const SplatCloud cloud = cloud_of(ball_shape(), 2000);
    for (double cell : {0.0, -1.0, std::nan("")})
        EXPECT_THROW(fill(cloud, options_of(cell)), std::invalid_argument);
    EXPECT_NE(reason<MemoryError>([&] { fill(cloud, options_of(1e-4)); }).find("particles need"),
              std::string::npos);
    EXPECT_NE(reason<InputError>([&] { fill(cloud, options_of(1e-12)); }), "");
    FillOptions small = options_of(0.1);
    small.max_bytes = 1 << 20;
    EXPECT_NE(reason<MemoryError>([&] { fill(cloud, small); }).find("1.0 MiB are allowed"),
              std::string::npos);
    EXPECT_NE(reason<InputError>([&] { fill({}, options_of(0.1)); }).find("found none"),
              std::string::npos);
}

TEST(Fill, AnObjectSmallerThanACellHasAParticle)
{
    const FilledObject o = fill(cloud_of(ball_shape(), 2000), options_of(10));
    EXPECT_GE(o.particles.size(), 1u);
}

TEST(Fill, StandsHostileClouds)
{
    SplatCloud cloud = cloud_of(ball_shape(), 3000);
    for (std::size_t i = 0; i < 200; ++i) {
        cloud.centre[i] = {i % 2 ? 1e30f : -1e30f, 1e38f, float(i)};
        cloud.scale[3 * i] = {0, 0, 1e38f};
        cloud.scale[3 * i + 1] = {0, 0, 0};
        cloud.opacity[5 * i] = i % 2 ? 0 : std::nanf("");
        cloud.rotation[7 * i] = {0, 0, 0, 0};
    }
    const FilledObject o = fill(cloud, options_of(1.0 / 16));
    EXPECT_GT(o.report.clean.dropped(), 400u);
    EXPECT_NEAR(o.report.volume / ball_shape().volume(), 1, 0.06);
    for (Vec3<float> x : o.splats.centre) ASSERT_LT(length(x), 2);
    for (Vec3<double> x : o.particles) ASSERT_LT(length(x), 0.6);
}

}  // namespace
}  // namespace knead
