// A lattice of which a box is stored, and how that box is chosen and grows.
#include "cuda/mpm/stored_region.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace knead {
namespace {

constexpr Int3 size{40, 24, 32};
const Lattice<float> whole{size, 0.125f};

bool inside(const Lattice<float>& l)
{
    const Int3 end = l.low + l.stored;
    return l.low.x >= 0 && l.low.y >= 0 && l.low.z >= 0 && end.x <= size.x && end.y <= size.y &&
           end.z <= size.z;
}

TEST(StoredRegion, EveryNodeThatIsStoredHasAnIndexOfItsOwn)
{
    const Lattice<float> l = boxed(whole, {9, 4, 13}, {30, 20, 17});
    EXPECT_EQ(l.low, (Int3{8, 4, 12}));
    EXPECT_EQ(l.stored, (Int3{24, 16, 8}));
    std::vector<int> seen(std::size_t(l.node_count()), 0);
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x) {
                const Int3 n{x, y, z};
                if (!l.stores(n)) continue;
                const int i = l.index(n);
                ASSERT_TRUE(i >= 0 && i < l.node_count());
                ++seen[std::size_t(i)];
                EXPECT_EQ(l.node_at(i), n);
                EXPECT_EQ(l.block_of(n), i / block_nodes);
                EXPECT_EQ(l.block_at(i / block_nodes), (Int3{x / 4, y / 4, z / 4}));
                for (const Int3& step : {Int3{1, 2, 3}, Int3{4, 0, 1}, Int3{0, 4, 4}})
                    EXPECT_TRUE(!l.stores(n + step) || l.stepped(i, step) == l.index(n + step));
            }
    for (const int times : seen) EXPECT_EQ(times, 1);
    EXPECT_EQ(l.block_count() * block_nodes, l.node_count());
}

TEST(StoredRegion, OfAWholeLatticeNothingIsDifferent)
{
    const Lattice<float> l = boxed(whole, {-7, -7, -7}, {99, 99, 99});
    EXPECT_EQ(l.node_count(), whole.node_count());
    EXPECT_EQ(l.index({5, 6, 7}), whole.index({5, 6, 7}));
    const Box3<float> b = stored_region(l);
    for (int k = 0; k < l.block_count(); ++k) EXPECT_EQ(ends_at(l, l.block_at(k)), 0u);
    // Walls, 2 nodes inside, are well within what is stored.
    const Vec3<float> low{0.125f * 1.87f, 0.125f * 1.87f, 0.125f * 1.87f};
    EXPECT_EQ(nearest(b, low).x, low.x);
    const Vec3<float> high = whole.dx * Vec3<float>{37.13f, 21.13f, 29.13f};
    EXPECT_EQ(nearest(b, high).y, high.y);
}

TEST(StoredRegion, WhereverClayIsPushedItsStencilIsStored)
{
    const Lattice<float> l = boxed(whole, {8, 4, 12}, {32, 20, 20});
    const Box3<float> b = stored_region(l);
    std::mt19937 random(7);
    std::uniform_real_distribution<float> anywhere(-1, 6);
    for (int k = 0; k < 100000; ++k) {
        const Vec3<float> x{anywhere(random), anywhere(random), anywhere(random)};
        const Vec3<float> to = nearest(b, x);
        const Int3 base = base_node(to, l.spacing);
        ASSERT_TRUE(l.stores(base) && l.stores(base + Int3{2, 2, 2}))
            << to.x << ' ' << to.y << ' ' << to.z;
        // Who is put back is seen at an end; who is not stays where it is.
        const bool stays = to.x == x.x && to.y == x.y && to.z == x.z;
        const Int3 high = base + Int3{2, 2, 2};
        ASSERT_TRUE(stays || ends_at(l, {base.x / 4, base.y / 4, base.z / 4}) ||
                    ends_at(l, {high.x / 4, high.y / 4, high.z / 4}));
        ASSERT_EQ(stays, contains(b, x));
    }
}

TEST(StoredRegion, FreeIsWhatIsWithinTheWallsAndStored)
{
    const Walls<float> walls = walls_on<float>(whole, walls_inside(whole, 3, ContactMode::slip, 0));
    const Lattice<float> l = boxed(whole, {8, 0, 8}, {40, 20, 32});
    const Box3<float> stored = stored_region(l), free = free_region(l, walls);
    EXPECT_EQ(free.low.x, stored.low.x);
    EXPECT_EQ(free.low.y, 3 * 0.125f);
    EXPECT_EQ(free.high.x, 36 * 0.125f);
    EXPECT_EQ(free.high.y, stored.high.y);
    EXPECT_EQ(free.high.z, 28 * 0.125f);
    EXPECT_FALSE(contains(free, {NAN, 1, 2}));
    EXPECT_TRUE(std::isnan(nearest(free, {NAN, 1, 2}).x));
}

TEST(StoredRegion, BlocksAtItsEndsAreThoseWhereTheLatticeGoesOn)
{
    const Lattice<float> l = boxed(whole, {8, 0, 8}, {32, 20, 32});
    int inner = 0;
    for (int k = 0; k < l.block_count(); ++k) {
        const Int3 b = l.block_at(k);
        const unsigned x = b.x == 2 ? 1u : b.x == 7 ? 2u : 0u;
        EXPECT_EQ(ends_at(l, b), x | (b.y == 4 ? 2u << 2 : 0u) | (b.z == 2 ? 1u << 4 : 0u));
        inner += ends_at(l, b) == 0;
    }
    EXPECT_EQ(inner, 4 * 4 * 5);
}

TEST(StoredRegion, TheBoxAroundClayIsNotLargerThanTheLatticeAndHasRoom)
{
    const Lattice<float> l = box_around(whole, {16, 10, 10}, {26, 14, 18}, -1);
    EXPECT_TRUE(inside(l));
    EXPECT_LT(l.node_count(), whole.node_count());
    for (const Int3& b : {Int3{4, 2, 2}, Int3{6, 3, 4}}) EXPECT_EQ(ends_at(l, b), 0u);
    // An eighth of the clay, at least a block.
    const Lattice<float> wide{{256, 256, 256}, 0.125f};
    const Lattice<float> large = box_around(wide, {96, 96, 96}, {160, 98, 104}, -1);
    EXPECT_EQ(large.low, (Int3{88, 92, 92}));
    EXPECT_EQ(large.stored, (Int3{80, 12, 16}));
    EXPECT_EQ(box_around(whole, {16, 10, 10}, {26, 14, 18}, 1 << 30).node_count(),
              whole.node_count());
}

TEST(StoredRegion, RowsAreOfAPowerOfTwoWhereThatIsNotMuchMore)
{
    const Lattice<float> wide{{128, 128, 96}, 0.125f};
    for (int from = 0; from < 96; from += 4)
        for (int to = from + 4; to <= 96; to += 4) {
            const Lattice<float> l = boxed(wide, {8, 12, from}, {20, 40, to}), e = in_even_rows(l);
            ASSERT_TRUE(e.low.x == 8 && e.low.y == 12 && e.stored.x == 12 && e.stored.y == 28);
            ASSERT_TRUE(e.low.z >= 0 && e.low.z % 4 == 0 && e.low.z <= from);
            const int end = e.low.z + e.stored.z, row = to - from;
            ASSERT_TRUE(end <= 96 && end % 4 == 0 && end >= to) << from << ' ' << to;
            int even = 4;
            while (even < row) even *= 2;
            ASSERT_EQ(e.stored.z, even > 96 || 5 * even > 8 * row ? row : even);
            ASSERT_EQ(e.index({8, 12, e.low.z}), 0);
        }
}

TEST(StoredRegion, ItGrowsWhereItIsToldToUntilItIsTheLattice)
{
    Lattice<float> l = box_around(whole, {16, 8, 8}, {20, 12, 12}, 0);
    const Lattice<float> first = l;
    l = grown(first, 1u | 2u << 4);
    EXPECT_LT(l.low.x, first.low.x);
    EXPECT_EQ(l.low.x + l.stored.x, first.low.x + first.stored.x);
    EXPECT_EQ(l.low.y, first.low.y);
    EXPECT_EQ(l.stored.y, first.stored.y);
    EXPECT_EQ(l.low.z, first.low.z);
    EXPECT_GT(l.stored.z, first.stored.z);
    for (int k = 0; k < 12; ++k, l = grown(l, 63u)) EXPECT_TRUE(inside(l));
    EXPECT_EQ(l.node_count(), whole.node_count());
}

}  // namespace
}  // namespace knead
