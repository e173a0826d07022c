// How a tile lists its splats.
#include "cuda/splats/tiles.h"

#include <gtest/gtest.h>

namespace knead {
namespace {

TEST(TilesOfSplats, AreListedByPartsWhereNothingIsKnown) { EXPECT_FALSE(best_whole(0, 0, parts)); }

TEST(TilesOfSplats, AreListedWholeWhereSplatsReachManyParts)
{
    EXPECT_TRUE(best_whole(10, 80, parts));
    EXPECT_TRUE(best_whole(10, 21, parts));
    EXPECT_FALSE(best_whole(10, 19, parts));
    EXPECT_FALSE(best_whole(10, 10, parts));
    EXPECT_FALSE(best_whole(10, 10, 1)) << "one block, one list";
    EXPECT_TRUE(best_whole(10, 20, 2)) << "both blocks need all";
}

TEST(TilesOfSplats, AreListedByPartsWhereListsAreLong)
{
    const unsigned most = longest_whole / sampling;
    EXPECT_TRUE(best_whole(most, 8 * most, parts));
    EXPECT_FALSE(best_whole(most + 1, 8 * most + 8, parts));
    EXPECT_FALSE(best_whole(150000, 1200000, parts));
}

// A tile at the rim, of which some parts or none are drawn, may have fewer entries than splats.
TEST(TilesOfSplats, OfWhichPartsAreNotDrawnAreChosenFrom)
{
    EXPECT_FALSE(best_whole(10, 3, 4));
    EXPECT_FALSE(best_whole(10, 0, 0));
    EXPECT_TRUE(best_whole(10, 40, 4));
}

}  // namespace
}  // namespace knead
