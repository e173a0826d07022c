// The solid found from splats against objects whose interior is known.
#include "host/assets/solid.h"

#include <gtest/gtest.h>

#include "host/assets/clean.h"
#include "host/base/errors.h"
#include "tests/assets/splat_shapes.h"
#include "tests/reason.h"
#include "tests/sanitized.h"

namespace knead {
namespace {

Solid found(const SplatCloud& cloud) { return find_solid(cloud, clean(cloud, {}).kept, {}); }

// Of half a million random points (a tenth of them under sanitizers): which share of those inside
// was found, and how many outside count as inside, over those inside. `margin` leaves out what is
// nearer to the surface, in grid spacings.
struct Shares {
    double inside = 0, wrong = 0;
};
Shares shares(const SplatShape& shape, const Solid& solid, double margin = 0)
{
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> along(-shape.half, shape.half);
    const double away = margin * solid.grid.h;
    double inside = 0, hit = 0, wrong = 0;
    for (int k = 0; k < (sanitized ? 50000 : 500000); ++k) {
        const double x = along(random), y = along(random), z = along(random);
        const double phi = shape.phi({x, y, z});
        if (std::abs(phi) < away) continue;
        const bool in = solid.inside({x, y, z}) > 0;
        inside += phi < 0;
        hit += phi < 0 && in;
        wrong += phi >= 0 && in;
    }
    return {hit / inside, wrong / inside};
}

TEST(Solid, OfCleanSplatsIsTheObjectToTheGridsSpacing)
{
    for (const SplatShape& shape : {ball_shape(), box_shape(), torus_shape(), bumpy_shape()}) {
        const Solid solid = found(cloud_of(shape, 20000));
        const Shares all = shares(shape, solid), away = shares(shape, solid, 1.5);
        EXPECT_GT(all.inside, 0.99) << shape.name;
        EXPECT_LT(all.wrong, 0.015) << shape.name;
        EXPECT_EQ(away.inside, 1) << shape.name;
        EXPECT_EQ(away.wrong, 0) << shape.name;
        EXPECT_NEAR(solid.volume / shape.volume(), 1, 0.02) << shape.name;
        EXPECT_EQ(solid.found, 1) << shape.name;
        EXPECT_LT(solid.unlit, shape.volume()) << shape.name;
    }
}

TEST(Solid, OfAVesselLeavesItsInsideEmpty)
{
    for (const SplatShape& shape : {bowl_shape(), cup_shape()}) {
        const Solid solid = found(cloud_of(shape, 20000));
        const Shares away = shares(shape, solid, 1.5);
        EXPECT_EQ(away.inside, 1) << shape.name;
        EXPECT_LT(away.wrong, 0.002) << shape.name;
        // Walls of seven spacings.
        EXPECT_NEAR(solid.volume / shape.volume(), 1, 0.05) << shape.name;
        EXPECT_LT(solid.inside({0, 0, 0}), -0.1) << shape.name;
    }
}

// No photograph tells a cavity that nobody sees into from a solid.
TEST(Solid, OfAShellHasItsClosedCavityFilled)
{
    const SplatShape shell = shell_shape(), ball = ball_shape();
    const Solid solid = found(cloud_of(shell, 30000));
    EXPECT_GT(shares(ball, solid, 1.5).inside, 0.999);
    EXPECT_NEAR(solid.volume / ball.volume(), 1, 0.02);
    EXPECT_GT(solid.inside({0, 0, 0}), 0.3);
}

TEST(Solid, ClosesAHoleOfATenthOfTheSurface)
{
    Spoil spoil;
    spoil.missing = [](Vec3<double> x) { return x.z > 0.4; };  // 0.1 of the ball's area
    const SplatShape ball = ball_shape();
    const Solid solid = found(cloud_of(ball, 20000, spoil));
    EXPECT_GT(shares(ball, solid).inside, 0.95);
    EXPECT_EQ(shares(ball, solid, 1.5).wrong, 0);
    EXPECT_NEAR(solid.volume / ball.volume(), 1, 0.05);
}

Spoil everything()
{
    Spoil spoil;
    spoil.noise = 0.004;
    spoil.faint = true;
    spoil.floaters = 0.02;
    spoil.huge = 0.001;
    spoil.flat = 0.2;
    spoil.twice = true;
    spoil.interior = 0.3;
    return spoil;
}

TEST(Solid, StandsNoiseFloatersInnerDegenerateHugeFaintAndDoubledSplats)
{
    for (const SplatShape& shape : {ball_shape(), box_shape(), torus_shape(), bumpy_shape()}) {
        const Solid solid = found(cloud_of(shape, 20000, everything()));
        const Shares all = shares(shape, solid), away = shares(shape, solid, 1.5);
        EXPECT_GT(all.inside, 0.94) << shape.name;
        EXPECT_LT(all.wrong, 0.06) << shape.name;
        EXPECT_EQ(away.inside, 1) << shape.name;
        EXPECT_LT(away.wrong, 0.001) << shape.name;
        EXPECT_NEAR(solid.volume / shape.volume(), 1, 0.05) << shape.name;
    }
    const SplatShape bowl = bowl_shape();
    const Solid solid = found(cloud_of(bowl, 20000, everything()));
    EXPECT_EQ(shares(bowl, solid, 1.5).inside, 1);
    EXPECT_LT(shares(bowl, solid, 1.5).wrong, 0.005);
    EXPECT_LT(solid.inside({0, 0, 0}), -0.1);
}

TEST(Solid, ClosesAHoleInASpoiltCloud)
{
    Spoil spoil = everything();
    spoil.missing = [](Vec3<double> x) { return x.z > 0.4; };
    const SplatShape ball = ball_shape();
    const Solid solid = found(cloud_of(ball, 20000, spoil));
    EXPECT_GT(shares(ball, solid).inside, 0.95);
    EXPECT_NEAR(solid.volume / ball.volume(), 1, 0.05);
}

// Nothing but the object's own size counts: not its place, not its unit of length.
TEST(Solid, GrowsAndMovesWithItsCloud)
{
    const SplatCloud cloud = cloud_of(bumpy_shape(), 8000);
    const Solid here = found(cloud);
    SplatCloud other = cloud;
    for (Vec3<float>& x : other.centre) x = 1024.0f * (x + Vec3<float>{2, -4, 8});
    for (Vec3<float>& s : other.scale) s = 1024.0f * s;
    const Solid there = found(other);
    EXPECT_NEAR(there.volume / (here.volume * 0x1p30), 1, 1e-3);
    EXPECT_NEAR(there.grid.h / here.grid.h, 1024, 1e-2);
}

SplatCloud in_one_point(std::size_t count, float scale)
{
    SplatCloud cloud;
    cloud.centre.assign(count, {1, 2, 3});
    cloud.rotation.assign(count, {1, 0, 0, 0});
    cloud.scale.assign(count, {scale, scale, scale});
    cloud.opacity.assign(count, 1);
    cloud.sh.assign(count, {0, 0, 0});
    return cloud;
}

TEST(Solid, RefusesCloudsWithoutAnObject)
{
    EXPECT_NE(reason<InputError>([] { find_solid({}, {}, {}); }).find("found none"),
              std::string::npos);
    const SplatCloud point = in_one_point(1000, 0);
    EXPECT_NE(reason<InputError>([&] { found(point); }).find("at one point"), std::string::npos);
}

TEST(Solid, StandsAMillionSplatsInOnePlaceAndSplatsOfAnySize)
{
    EXPECT_GT(found(in_one_point(1000000, 0.1f)).grid.count(), 0u);
    for (float scale : {1e-30f, 1e30f}) {
        SplatCloud cloud = cloud_of(ball_shape(), 2000);
        for (Vec3<float>& s : cloud.scale) s = {scale, scale, 0};
        const Solid solid = found(cloud);
        EXPECT_LT(solid.grid.count(), 5000000u) << scale;
        for (float v : solid.indicator) ASSERT_TRUE(std::isfinite(v)) << scale;
        EXPECT_TRUE(std::isfinite(solid.volume)) << scale;
    }
}

}  // namespace
}  // namespace knead
