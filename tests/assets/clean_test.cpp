// What is no part of a photographed object is left out of it, counted by its reason.
#include "host/assets/clean.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/assets/splat_shapes.h"

namespace knead {
namespace {

void add(SplatCloud& cloud, Vec3<float> x, float scale, float opacity)
{
    cloud.centre.push_back(x);
    cloud.rotation.push_back({1, 0, 0, 0});
    cloud.scale.push_back({scale, scale, scale});
    cloud.opacity.push_back(opacity);
    cloud.sh.push_back({0, 0, 0});
}

TEST(Clean, KeepsAllOfACleanObject)
{
    for (const SplatShape& shape : {ball_shape(), box_shape(), torus_shape(), cup_shape()}) {
        const SplatCloud cloud = cloud_of(shape, 5000);
        EXPECT_EQ(clean(cloud, {}).kept.size(), cloud.count()) << shape.name;
    }
}

TEST(Clean, LeavesOutWhatIsSpoiltAndCountsItsReason)
{
    SplatCloud cloud = cloud_of(ball_shape(), 5000);
    const float none = std::numeric_limits<float>::quiet_NaN();
    add(cloud, {none, 0, 0}, 0.01f, 1);
    add(cloud, {0, 0.5f, 0}, none, 1);
    add(cloud, {0, 0, 0.5f}, 0.01f, 0.01f);
    add(cloud, {1e30f, 0, 0}, 0.01f, 1);
    add(cloud, {0, 0, -3}, 0.01f, 1);
    add(cloud, {0, 0, 0.5f}, 1.5f, 1);
    add(cloud, {0, 0, 0.5f}, 1e30f, 1);
    add(cloud, {0, 0, 0.5f}, 0.8f, 1);
    add(cloud, {0.9f, 0, 0}, 0.01f, 1);
    const CleanCloud c = clean(cloud, {});
    EXPECT_EQ(c.kept.size(), 5000u);
    EXPECT_EQ(c.kept.back(), 4999u);
    EXPECT_EQ(c.report.not_finite, 2u);
    EXPECT_EQ(c.report.faint, 1u);
    EXPECT_EQ(c.report.far, 2u);
    EXPECT_EQ(c.report.huge, 3u);
    EXPECT_EQ(c.report.isolated, 1u);
}

TEST(Clean, FindsNineOfTenFloaters)
{
    Spoil spoil;
    spoil.floaters = 0.02;
    const SplatCloud cloud = cloud_of(ball_shape(), 20000, spoil);
    const CleanCloud c = clean(cloud, {});
    std::size_t floaters = 0, lost = 0, left = 0;
    std::vector<char> kept(cloud.count());
    for (std::uint32_t i : c.kept) kept[i] = 1;
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        const bool floats = length(cast<double>(cloud.centre[i])) > 0.6;
        floaters += floats;
        left += floats && kept[i];
        lost += i < 20000 && !kept[i];
    }
    EXPECT_GT(floaters, 300u);
    EXPECT_LT(left, floaters / 10);
    EXPECT_EQ(lost, 0u);
}

TEST(Clean, StandsCloudsWithoutAnObject)
{
    EXPECT_TRUE(clean({}, {}).kept.empty());
    SplatCloud one;
    add(one, {1, 2, 3}, 0.1f, 1);
    EXPECT_EQ(clean(one, {}).kept.size(), 1u);
    SplatCloud faint;
    add(faint, {1, 2, 3}, 0.1f, 0);
    EXPECT_TRUE(clean(faint, {}).kept.empty());
    SplatCloud same;
    for (int i = 0; i < 100000; ++i) add(same, {1, 2, 3}, 0, 1);
    EXPECT_EQ(clean(same, {}).kept.size(), 100000u);
}

}  // namespace
}  // namespace knead
