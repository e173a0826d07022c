// The object that a hand touches or points at.
#include "host/ui/hover.h"

#include <gtest/gtest.h>

#include <cmath>

namespace knead {
namespace {

using V = Vec3<double>;

// Cubes of 0.2 m, of samples 1 cm apart.
struct Table {
    Document document;
    ObjectPlaces places;
    Hover hover;

    void add(unsigned id, V centre, bool hidden = false)
    {
        SceneObject object;
        object.id = {id}, object.hidden = hidden;
        document.objects.push_back(std::make_shared<const SceneObject>(object));
        ObjectPlace place{{id}, {centre, centre}, centre, 0.01, {}, 0.01};
        for (int i = 0; i < 21 * 21 * 21; ++i) {
            const V x = centre + 0.01 * V{i % 21 - 10.0, i / 21 % 21 - 10.0, i / 441 - 10.0};
            grow(place.box, x);
            place.some.push_back(cast<float>(x));
        }
        places.all.push_back(place);
    }
    unsigned at(V point, V ray = {0, 1, 0}, bool rays = true)
    {
        const auto& found = hover.frame(places, document, {point, 0.02, ray, 2, rays});
        return found ? found->object.value : 0;
    }
};

TEST(Hover, TouchesTheNearestClayWithinReach)
{
    Table t;
    t.add(1, {0, 0, 0}), t.add(2, {0.23, 0, 0});
    EXPECT_EQ(t.at({0.11, 0, 0}), 1u);
    EXPECT_TRUE(t.hover.now()->touched);
    t.hover.clear();
    EXPECT_EQ(t.at({0.122, 0, 0}), 2u);
    t.hover.clear();
    EXPECT_EQ(t.at({-0.13, 0, 0}), 0u) << "2 cm from the clay, which is half a sample further";
    EXPECT_EQ(t.at({0.05, 0, 0}), 1u) << "inside";
    EXPECT_EQ(t.hover.now()->distance, 0);
}

TEST(Hover, KeepsItsObjectUntilAnotherIsClearlyNearer)
{
    Table t;
    t.add(1, {0, 0, 0}), t.add(2, {0.23, 0, 0});
    EXPECT_EQ(t.at({0.11, 0, 0}), 1u);
    EXPECT_EQ(t.at({0.116, 0, 0}), 1u) << "the other is nearer by 2 mm";
    EXPECT_EQ(t.at({0.12, 0, 0}), 2u);
    EXPECT_EQ(t.at({0.116, 0, 0}), 2u);
    Table alone;
    alone.add(1, {0, 0, 0});
    EXPECT_EQ(alone.at({0, -0.13, 0}, {0, -1, 0}), 0u);
    EXPECT_EQ(alone.at({0, -0.12, 0}, {0, -1, 0}), 1u);
    EXPECT_EQ(alone.at({0, -0.13, 0}, {0, -1, 0}), 1u) << "left at one and a half times the reach";
    EXPECT_EQ(alone.at({0, -0.14, 0}, {0, -1, 0}), 0u);
}

TEST(Hover, PointsAtTheFirstClayOfARay)
{
    Table t;
    t.add(1, {0, 0, 0}), t.add(2, {0.5, 0, 0});
    EXPECT_EQ(t.at({-1, 0, 0}, {1, 0, 0}), 1u);
    EXPECT_FALSE(t.hover.now()->touched);
    EXPECT_NEAR(t.hover.now()->point.x, -0.1, 0.011);
    t.hover.clear();
    EXPECT_EQ(t.at({1.5, 0, 0}, {-1, 0, 0}), 2u);
    EXPECT_EQ(t.at({-1, 0.3, 0}, {1, 0, 0}), 0u);
    EXPECT_EQ(t.at({-3, 0, 0}, {1, 0, 0}), 0u) << "beyond its range";
    EXPECT_EQ(t.at({-1, 0, 0}, {-1, 0, 0}), 0u) << "behind";
    EXPECT_EQ(t.at({-1, 0, 0}, {1, 0, 0}, false), 0u);
}

TEST(Hover, ARayThatShakesKeepsItsObject)
{
    Table t;
    t.add(1, {0, 0, 0});
    EXPECT_EQ(t.at({-1, 0.115, 0}, {1, 0, 0}), 0u);
    EXPECT_EQ(t.at({-1, 0.105, 0}, {1, 0, 0}), 1u);
    EXPECT_EQ(t.at({-1, 0.115, 0}, {1, 0, 0}), 1u);
    EXPECT_EQ(t.at({-1, 0.15, 0}, {1, 0, 0}), 0u);
}

TEST(Hover, LeavesOutHiddenObjectsAndThoseThatAreGone)
{
    Table t;
    t.add(1, {0, 0, 0}, true);
    EXPECT_EQ(t.at({0, 0, 0}), 0u);
    t.document.objects.clear();
    EXPECT_EQ(t.at({0, 0, 0}), 0u);
    Table other;
    other.add(4, {0, 0, 0});
    EXPECT_EQ(other.at({0, 0, 0}), 4u);
    other.places.all.clear();
    EXPECT_EQ(other.at({0, 0, 0}), 0u);
}

}  // namespace
}  // namespace knead
