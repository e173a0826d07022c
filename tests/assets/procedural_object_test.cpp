// The pot is what its header says, and the filling finds it.
#include "host/assets/procedural_object.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "host/assets/fill.h"

namespace knead {
namespace {

TEST(GlazedPot, HasOpaqueSplatsOfOneSizeAndOfAspectBelowTwo)
{
    const SplatCloud pot = glazed_pot();
    ASSERT_EQ(pot.count(), 30000u);
    ASSERT_EQ(pot.sh.size(), 30000u * 9);
    std::vector<double> volumes;
    for (std::size_t i = 0; i < pot.count(); ++i) {
        const Vec3<float> s = pot.scale[i];
        std::array<float, 3> a{s.x, s.y, s.z};
        std::sort(a.begin(), a.end());
        ASSERT_GT(a[0], 0);
        ASSERT_LE(a[2] / a[0], 2);
        volumes.push_back(double(a[0]) * a[1] * a[2]);
        ASSERT_GE(pot.opacity[i], 0.95f);
        ASSERT_LE(pot.opacity[i], 1);
        const Quat<float> q = pot.rotation[i];
        ASSERT_NEAR(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z, 1, 1e-5);
    }
    const auto [least, most] = std::minmax_element(volumes.begin(), volumes.end());
    EXPECT_LT(*most / *least, 2);
}

TEST(GlazedPot, StandsOnTheFloorAndHasNoGapWiderThanItsSplats)
{
    const SplatCloud pot = glazed_pot();
    float low = 1, high = 0;
    for (Vec3<float> x : pot.centre) low = min(low, x.y), high = max(high, x.y);
    EXPECT_NEAR(low, 0, 0.002);
    EXPECT_NEAR(high, 0.2, 0.01);
    // The sixth neighbour of any is near: the cover is even.
    for (std::size_t i = 0; i < pot.count(); i += 1500) {
        std::vector<float> d;
        for (Vec3<float> x : pot.centre) d.push_back(length(x - pot.centre[i]));
        std::nth_element(d.begin(), d.begin() + 6, d.end());
        EXPECT_LT(d[6], 3 * pot.scale[i].x) << i;
    }
}

TEST(GlazedPot, IsFilledToItsVolume)
{
    FillOptions options;
    options.cell = 0.2 / 32;
    const FilledObject o = fill(glazed_pot(), options);
    EXPECT_EQ(o.report.clean.dropped(), 0u);
    EXPECT_EQ(o.surface, 30000u);
    EXPECT_EQ(o.report.found, 1);
    EXPECT_NEAR(double(o.particles.size()) * o.particle_volume / glazed_pot_volume(), 1, 0.01);
}

TEST(GlazedPot, IsTheSameEachTimeAndFitsASmallFile)
{
    const SplatCloud one = glazed_pot(), two = glazed_pot(), other = glazed_pot(30000, 2);
    EXPECT_EQ(splat_bytes(one), splat_bytes(two));
    EXPECT_NE(splat_bytes(one), splat_bytes(other));
    EXPECT_LT(splat_bytes(one).size(), std::size_t(1) << 20);
    EXPECT_LT(spz_bytes(one, "pot.spz").size(), std::size_t(1) << 20);
    EXPECT_THROW(glazed_pot(99), std::invalid_argument);
}

}  // namespace
}  // namespace knead
