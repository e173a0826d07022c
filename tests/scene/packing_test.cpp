// Particles that fill a shape: its volume, the lattice inside, the same for any number of threads.
#include "host/scene/packing.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

#include "host/base/parallel.h"
#include "host/scene/strata.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

using Points = std::vector<Vec3<double>>;

struct Shape {
    std::string name;
    double volume;  // [m^3]
    Depth depth;
};

Shape ball(Vec3<double> c, double r)
{
    return {"ball", 4 * std::numbers::pi / 3 * r * r * r,
            [=](Vec3<double> x) { return r - length(x - c); }};
}
Shape box(Vec3<double> c, Vec3<double> half)
{
    return {"box", 8 * half.x * half.y * half.z, [=](Vec3<double> x) {
                const Vec3<double> d = x - c;
                return std::min(
                    {half.x - std::abs(d.x), half.y - std::abs(d.y), half.z - std::abs(d.z)});
            }};
}
Shape cylinder(Vec3<double> c, double r, double half)
{
    return {"cylinder", 2 * std::numbers::pi * r * r * half, [=](Vec3<double> x) {
                const Vec3<double> d = x - c;
                return std::min(half - std::abs(d.y), r - std::hypot(d.x, d.z));
            }};
}

// In the cube of 1 m.
Packing packing_of(double h, double per_cell = 8, unsigned seed = 1)
{
    const int n = int(std::ceil(1 / h));
    return {h, per_cell, seed, 0, {0, 0, 0}, {n, n, n}};
}

TEST(Packing, ParticlesAreInsideAndHaveTheVolume)
{
    Draw draw(4);
    for (int round = 0; round < 4; ++round) {
        const Vec3<double> c = Vec3<double>{0.5, 0.5, 0.5} + draw.vector(0.05);
        for (const Shape& shape :
             {ball(c, 0.3), box(c, {0.2, 0.11, 0.32}), cylinder(c, 0.25, 0.13)}) {
            const double h = 1.0 / 48;
            const Points x = packed(packing_of(h), shape.depth);
            EXPECT_NEAR(double(x.size()) * h * h * h / shape.volume, 1, 1e-3) << shape.name;
            for (const Vec3<double> p : x) EXPECT_GE(shape.depth(p), 0) << shape.name;
        }
    }
}

TEST(Packing, AShapeThinnerThanAStratumHasItsVolume)
{
    const double h = 1.0 / 40;
    const Shape sheet = box({0.5, 0.51, 0.5}, {0.3, 0.15 * h, 0.3});
    const Points x = packed(packing_of(h), sheet.depth);
    EXPECT_NEAR(double(x.size()) * h * h * h / sheet.volume, 1, 0.01);
    EXPECT_TRUE(packed(packing_of(h), box({0.5, 0.5, 0.5}, {h / 4, h / 4, h / 4}).depth).empty());
}

TEST(Packing, InsideIsTheLatticeAndItsJitter)
{
    const double h = 1.0 / 48;
    const Shape shape = ball({0.51, 0.48, 0.5}, 0.35);
    for (const double per_cell : {8.0, 4.0}) {
        using Place = std::tuple<double, double, double>;
        std::set<Place> places;
        for (const Vec3<double> p : packed(packing_of(h, per_cell), shape.depth))
            places.insert({std::round(1e9 * p.x), std::round(1e9 * p.y), std::round(1e9 * p.z)});
        int deep = 0;
        for (int i = 0; i < 48 * 48 * 48; ++i) {
            const Int3 s{i % 48, i / 48 % 48, i / (48 * 48)};
            const Vec3<double> p = stratum_place(1, 0, s, h, per_cell);
            if (shape.depth(p) < 5 * h) continue;
            EXPECT_TRUE(places.contains(
                {std::round(1e9 * p.x), std::round(1e9 * p.y), std::round(1e9 * p.z)}));
            ++deep;
        }
        EXPECT_GT(deep, 5000);
    }
}

TEST(Packing, ABoxOfWholeStrataHasOneParticleInEach)
{
    const double h = 1.0 / 32;
    const Points x = packed(packing_of(h), box({0.5, 0.5, 0.5}, {6 * h, 4 * h, 5 * h}).depth);
    ASSERT_EQ(x.size(), 12u * 8 * 10);
    std::set<std::tuple<int, int, int>> strata;
    for (const Vec3<double> p : x) strata.insert({int(p.x / h), int(p.y / h), int(p.z / h)});
    EXPECT_EQ(strata.size(), x.size());
}

TEST(Packing, NeighboursKeepADistance)
{
    const double h = 1.0 / 32;
    const Points x = packed(packing_of(h), ball({0.507, 0.493, 0.51}, 0.25).depth);
    double nearest = 1;
    for (std::size_t i = 0; i < x.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) nearest = std::min(nearest, length(x[i] - x[j]));
    EXPECT_GT(nearest, 0.5 * h);
}

TEST(Packing, SameBitsFromOneTwoAndThreeThreadsOthersFromAnotherSeed)
{
    const double h = 1.0 / 32;
    const Depth depth = ball({0.5, 0.5, 0.5}, 0.3).depth;
    const int before = loop_threads();
    std::vector<Points> runs;
    for (const int threads : {1, 2, 3}) {
        set_loop_threads(threads);
        runs.push_back(packed(packing_of(h), depth));
    }
    set_loop_threads(before);
    const auto same = [](const Points& a, const Points& b) {
        return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                          [](auto p, auto q) { return p.x == q.x && p.y == q.y && p.z == q.z; });
    };
    EXPECT_TRUE(same(runs[0], runs[1]));
    EXPECT_TRUE(same(runs[0], runs[2]));
    EXPECT_FALSE(same(runs[0], packed(packing_of(h, 8, 2), depth)));
}

}  // namespace
}  // namespace knead
