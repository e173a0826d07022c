// The floor of our own in splats.
#include "host/assets/procedural_ground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

namespace knead {
namespace {

TEST(TiledGround, IsOneByOneMetreAndNearlyFlat)
{
    const SplatCloud c = tiled_ground(5000);
    ASSERT_EQ(c.count(), 5000u);
    ASSERT_EQ(c.sh.size(), 5000u);
    for (std::size_t i = 0; i < c.count(); ++i) {
        const Vec3<float> x = c.centre[i], s = c.scale[i];
        EXPECT_LE(std::fabs(x.x), 0.5f);
        EXPECT_LE(std::fabs(x.z), 0.51f);
        EXPECT_LE(std::fabs(x.y), 0.012f);
        EXPECT_LT(s.z, 0.6f * s.x);
    }
    EXPECT_THROW(tiled_ground(10), std::invalid_argument);
}

TEST(GroundOfTheScenes, IsTheOneThatIsGenerated)
{
    const SplatCloud file = read_splats("scenes/ground.spz").cloud, made = tiled_ground();
    ASSERT_EQ(file.count(), made.count());
    double farthest = 0;
    for (std::size_t i = 0; i < made.count(); ++i)
        farthest = std::fmax(farthest, double(length(file.centre[i] - made.centre[i])));
    EXPECT_LT(farthest, 5e-4);  // SPZ's steps
}

}  // namespace
}  // namespace knead
