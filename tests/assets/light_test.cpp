// Light from all sides against closed forms of slabs and balls, and Poisson's equation against the
// eigenfunctions of its stencil.
#include "host/assets/light.h"

#include <gtest/gtest.h>

#include <numbers>
#include <stdexcept>

#include "host/assets/poisson.h"
#include "host/base/parallel.h"

namespace knead {
namespace {

using std::numbers::pi;

Grid cube(int nodes, double h) { return {{0, 0, 0}, h, {nodes, nodes, nodes}}; }

template <class Phi>
std::vector<float> filled_where(const Grid& grid, float extinction, Phi&& inside)
{
    std::vector<float> f(grid.count());
    for (std::size_t i = 0; i < f.size(); ++i)
        if (inside(grid.position(grid.node(i)))) f[i] = extinction;
    return f;
}

TEST(Light, OpenSkyReachesAllOfAnEmptyBox)
{
    const Grid grid = cube(9, 0.5);
    const Light light = lit_from_all_sides(grid, std::vector<float>(grid.count()), 50);
    for (float s : light.seen) EXPECT_NEAR(s, 1, 1e-5);
    for (Vec3<float> p : light.pressure) EXPECT_EQ(length(p), 0);
}

TEST(Light, AWideSlabHidesHalfOfTheSkyAndIsPressedByOneAlongItsNormal)
{
    const Grid grid{{0, 0, 0}, 0.1, {201, 201, 11}};
    const std::vector<float> slab =
        filled_where(grid, 60, [](Vec3<double> x) { return std::abs(x.z - 0.5) < 0.15; });
    const Light light = lit_from_all_sides(grid, slab, 200);
    EXPECT_NEAR(light.seen[grid.at({100, 100, 7})], 0.5, 0.03);
    Vec3<float> from_above{}, from_below{};
    for (int z = 0; z < 11; ++z) {
        Vec3<float>& sum = z > 5 ? from_above : from_below;
        if (z != 5) sum = sum + float(grid.h) * light.pressure[grid.at({100, 100, z})];
    }
    EXPECT_NEAR(from_above.z, -1, 0.03);
    EXPECT_NEAR(from_below.z, 1, 0.03);
    for (Vec3<float> p : {from_above, from_below}) EXPECT_LT(std::hypot(p.x, p.y), 0.03);
    EXPECT_LT(light.seen[grid.at({100, 100, 5})], 1e-3);
}

TEST(Light, PressureOnABallIsItsVectorAreaHoweverThickTheSkin)
{
    const Grid grid = cube(65, 1.0 / 64);
    const Vec3<double> middle{0.5, 0.5, 0.5};
    for (double inner : {0.0, 0.3}) {
        const std::vector<float> ball = filled_where(grid, 400, [&](Vec3<double> x) {
            const double r = length(x - middle);
            return r < 0.4 && r >= inner;
        });
        const Light light = lit_from_all_sides(grid, ball, 96);
        double area = 0;
        Vec3<double> total{};
        for (std::size_t i = 0; i < ball.size(); ++i) {
            const Vec3<double> p = cast<double>(light.pressure[i]),
                               r = grid.position(grid.node(i)) - middle;
            if (ball[i] > 0) area -= dot(p, r) / max(length(r), 1e-9);
            total = total + p;
        }
        const double cell = grid.h * grid.h * grid.h;
        EXPECT_NEAR(area * cell / (4 * pi * 0.16), 1, 0.03) << inner;
        EXPECT_LT(length(total) * cell, 0.01 * 4 * pi * 0.16);
    }
}

TEST(Light, HasTheSameBitsForAnyNumberOfThreads)
{
    const Grid grid = cube(33, 1.0 / 32);
    const std::vector<float> box = filled_where(
        grid, 50, [](Vec3<double> x) { return max(max(x.x, x.y), x.z) < 0.6 && x.x > 0.2; });
    const int before = loop_threads();
    set_loop_threads(1);
    const Light one = lit_from_all_sides(grid, box, 40);
    const std::vector<float> solved = solve_poisson(grid, box);
    set_loop_threads(3);
    const Light three = lit_from_all_sides(grid, box, 40);
    EXPECT_EQ(solved, solve_poisson(grid, box));
    set_loop_threads(before);
    EXPECT_EQ(one.seen, three.seen);
    for (std::size_t i = 0; i < one.pressure.size(); ++i)
        ASSERT_EQ(length(one.pressure[i] - three.pressure[i]), 0) << i;
}

TEST(Poisson, SolvesForTheEigenfunctionsOfItsStencil)
{
    const Grid grid{{0, 0, 0}, 0.05, {33, 65, 49}};
    for (Int3 k : {Int3{1, 1, 1}, Int3{3, 2, 7}, Int3{15, 30, 20}}) {
        const auto wave = [&](Int3 n) {
            return std::sin(pi * k.x * n.x / 32) * std::sin(pi * k.y * n.y / 64) *
                   std::sin(pi * k.z * n.z / 48);
        };
        const auto part = [&](int kk, int cells) {
            const double s = std::sin(pi * kk / (2.0 * cells));
            return -4 * s * s / (grid.h * grid.h);
        };
        const double eigenvalue = part(k.x, 32) + part(k.y, 64) + part(k.z, 48);
        std::vector<float> f(grid.count());
        for (std::size_t i = 0; i < f.size(); ++i) f[i] = float(eigenvalue * wave(grid.node(i)));
        const std::vector<float> u = solve_poisson(grid, f);
        double worst = 0;
        for (std::size_t i = 0; i < f.size(); ++i)
            worst = max(worst, std::abs(double(u[i]) - wave(grid.node(i))));
        EXPECT_LT(worst, 2e-5) << k.x;
    }
}

TEST(Poisson, RefusesEdgesThatCannotBeHalved)
{
    for (Int3 size : {Int3{33, 33, 32}, Int3{1, 17, 17}, Int3{17, 25, 17}}) {
        const Grid grid{{0, 0, 0}, 1, size};
        EXPECT_THROW(solve_poisson(grid, std::vector<float>(grid.count())), std::invalid_argument);
    }
}

}  // namespace
}  // namespace knead
