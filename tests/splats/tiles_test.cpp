// How a tile lists its splats.
#include "cuda/splats/tiles.h"

#include <gtest/gtest.h>

namespace knead {
namespace {

TEST(TilesOfSplats, AreListedByPartsWhereNothingIsKnown)
{
    EXPECT_FALSE(prefer_whole_list(0, 0, parts));
}

TEST(TilesOfSplats, AreListedWholeWhereSplatsReachManyParts)
{
    EXPECT_TRUE(prefer_whole_list(10, 80, parts));
    EXPECT_TRUE(prefer_whole_list(10, 21, parts));
    EXPECT_FALSE(prefer_whole_list(10, 19, parts));
    EXPECT_FALSE(prefer_whole_list(10, 10, parts));
    EXPECT_FALSE(prefer_whole_list(10, 10, 1)) << "one block, one list";
    EXPECT_TRUE(prefer_whole_list(10, 20, 2)) << "both blocks need all";
}

TEST(TilesOfSplats, AreListedByPartsWhereListsAreLong)
{
    const unsigned most = longest_whole / sampling;
    EXPECT_TRUE(prefer_whole_list(most, 8 * most, parts));
    EXPECT_FALSE(prefer_whole_list(most + 1, 8 * most + 8, parts));
    EXPECT_FALSE(prefer_whole_list(150000, 1200000, parts));
}

// A tile at the rim, of which some parts or none are drawn, may have fewer entries than splats.
TEST(TilesOfSplats, OfWhichPartsAreNotDrawnAreChosenFrom)
{
    EXPECT_FALSE(prefer_whole_list(10, 3, 4));
    EXPECT_FALSE(prefer_whole_list(10, 0, 0));
    EXPECT_TRUE(prefer_whole_list(10, 40, 4));
}

// Whatever the step of its samples, the parts that are drawn of a tile fill it once, and where a
// square of it is seen the part that has its pixels is drawn.
TEST(TilesOfSplats, AreFilledByThePartsThatAreDrawn)
{
    for (const int step : {1, 2, 4}) {
        for (unsigned seen = 0; seen < 1u << parts; ++seen) {
            const unsigned drawn = drawn_parts(seen, step);
            for (int n = 0; n < parts; ++n) {
                if (!(seen >> n & 1)) continue;
                const PartBox b = part_box(n, 1);
                int owners = 0;
                for (int k = 0; k < parts; ++k) {
                    const PartBox of = part_box(k, step);
                    owners += (drawn >> k & 1) && of.x <= b.x && b.x + b.width <= of.x + of.width &&
                              of.y <= b.y && b.y + b.height <= of.y + of.height;
                }
                EXPECT_EQ(owners, 1) << step << ' ' << seen << ' ' << n;
            }
            EXPECT_EQ(drawn == 0, seen == 0);
        }
        int pixels = 0;
        for (int k = 0; k < parts; ++k)
            if (drawn_parts((1u << parts) - 1, step) >> k & 1)
                pixels += part_box(k, step).width * part_box(k, step).height;
        EXPECT_EQ(pixels, tile_size * tile_size);
    }
}

}  // namespace
}  // namespace knead
