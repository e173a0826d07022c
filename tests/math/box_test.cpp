// Axis-aligned boxes: growth, margins, membership.
#include "cuda/math/box.h"

#include <gtest/gtest.h>

#include <cmath>

namespace knead {
namespace {

template <class R>
class BoxTest : public testing::Test {
};
using Reals = testing::Types<float, double>;
TYPED_TEST_SUITE(BoxTest, Reals);

template <class R>
bool equal(const Box3<R>& a, const Box3<R>& b)
{
    return length(a.low - b.low) == 0 && length(a.high - b.high) == 0;
}

TYPED_TEST(BoxTest, GrowsFromNothingToThePointsAndBoxesAdded)
{
    using R = TypeParam;
    Box3<R> box = empty_box<R>();
    EXPECT_TRUE(empty(box));
    EXPECT_FALSE(contains(box, {0, 0, 0}));
    grow(box, empty_box<R>());
    EXPECT_TRUE(empty(box));
    grow(box, Vec3<R>{1, 2, 3});
    EXPECT_FALSE(empty(box));
    EXPECT_TRUE(equal(box, {{1, 2, 3}, {1, 2, 3}}));
    grow(box, Vec3<R>{-1, 4, R(NAN)});
    EXPECT_TRUE(equal(box, {{-1, 2, 3}, {1, 4, 3}}));
    grow(box, Box3<R>{{0, 0, 2}, {5, 1, 4}});
    EXPECT_TRUE(equal(box, {{-1, 0, 2}, {5, 4, 4}}));
    EXPECT_TRUE(equal(expanded(box, R(0.5)), {{-1.5, -0.5, 1.5}, {5.5, 4.5, 4.5}}));
    EXPECT_EQ(length(centre(box) - Vec3<R>{2, 2, 3}), 0);
    EXPECT_EQ(length(edges(box) - Vec3<R>{6, 4, 2}), 0);
    EXPECT_EQ(longest_edge(box), 6);
}

TYPED_TEST(BoxTest, ContainsItsFacesAndOverlapsWhatTouchesIt)
{
    using R = TypeParam;
    const Box3<R> box{{0, 0, 0}, {1, 2, 3}};
    for (const Vec3<R> x : {box.low, box.high, centre(box), Vec3<R>{1, 0, 3}})
        EXPECT_TRUE(contains(box, x));
    const R nan = R(NAN);
    for (const Vec3<R> x : {Vec3<R>{R(-0.1), 1, 1}, {1, R(2.1), 1}, {1, 1, R(3.1)}, {1, nan, 1}})
        EXPECT_FALSE(contains(box, x));
    for (const Vec3<R> step : {Vec3<R>{1, 0, 0}, {0, -2, 0}, {1, 2, 3}, {R(0.5), 1, -1}}) {
        const Box3<R> moved{box.low + step, box.high + step};
        EXPECT_TRUE(intersects(box, moved) && intersects(moved, box));
    }
    for (const Vec3<R> step : {Vec3<R>{R(1.1), 0, 0}, {0, R(-2.1), 0}, {0, 0, R(3.1)}}) {
        const Box3<R> moved{box.low + step, box.high + step};
        EXPECT_FALSE(intersects(box, moved) || intersects(moved, box));
    }
    EXPECT_FALSE(intersects(box, empty_box<R>()));
}

TYPED_TEST(BoxTest, NearestPointIsInTheBoxAndUnchangedInside)
{
    using R = TypeParam;
    const Box3<R> box{{0, 0, 0}, {1, 2, 3}};
    EXPECT_EQ(length(nearest(box, {R(0.5), 1, 3}) - Vec3<R>{R(0.5), 1, 3}), 0);
    EXPECT_EQ(length(nearest(box, {-1, 1, 7}) - Vec3<R>{0, 1, 3}), 0);
    EXPECT_TRUE(std::isnan(nearest(box, {R(NAN), 1, 1}).x));
}

}  // namespace
}  // namespace knead
