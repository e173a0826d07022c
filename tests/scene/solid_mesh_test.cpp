// Meshes as bodies: what is inside, how deep, how much; holes; the lattice that fills them.
#include "host/scene/solid_mesh.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <iostream>
#include <map>
#include <numbers>

#include "host/scene/closed_surface.h"
#include "host/scene/shapes.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

struct Triangles {
    std::vector<Vec3<double>> vertices;
    std::vector<Int3> triangles;
};

void add(Triangles& to, const Triangles& other, Vec3<double> by = {}, bool inwards = false)
{
    const int before = int(to.vertices.size());
    for (const Vec3<double>& x : other.vertices) to.vertices.push_back(x + by);
    for (Int3 t : other.triangles) {
        if (inwards) std::swap(t.y, t.z);
        to.triangles.push_back(t + Int3{before, before, before});
    }
}

// With every corner three times, as files with a normal for each side have it.
Triangles box(Vec3<double> half)
{
    Triangles m;
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) {
            const int first = int(m.vertices.size());
            for (const auto& [u, v] : {std::pair{-1.0, -1.0}, {1, -1}, {1, 1}, {-1, 1}}) {
                const double c[3] = {side, side * u, v};
                m.vertices.push_back({half.x * c[(3 - axis) % 3], half.y * c[(4 - axis) % 3],
                                      half.z * c[(5 - axis) % 3]});
            }
            m.triangles.push_back({first, first + 1, first + 2});
            m.triangles.push_back({first, first + 2, first + 3});
        }
    return m;
}

// A sphere of so many triangles around, with waves.
Triangles ball(int n, double waves = 0, double radius = 1)
{
    Triangles m;
    const auto place = [&](double a, double b) {
        const double r = radius * (1 + waves * std::sin(6 * a) * std::sin(5 * b) * std::sin(a));
        m.vertices.push_back(
            {r * std::sin(a) * std::cos(b), r * std::cos(a), r * std::sin(a) * std::sin(b)});
    };
    for (int i = 0; i <= n; ++i)
        for (int k = 0; k < 2 * n; ++k) place(std::numbers::pi * i / n, std::numbers::pi * k / n);
    const auto at = [&](int i, int k) { return i * 2 * n + k % (2 * n); };
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < 2 * n; ++k) {
            if (i > 0) m.triangles.push_back({at(i, k), at(i, k + 1), at(i + 1, k)});
            if (i < n - 1) m.triangles.push_back({at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)});
        }
    // The poles are one place each.
    for (int k = 1; k < 2 * n; ++k)
        m.vertices[std::size_t(at(0, k))] = m.vertices[0], m.vertices[std::size_t(at(n, k))] =
                                                               m.vertices[std::size_t(at(n, 0))];
    return m;
}

std::shared_ptr<const SolidMesh> solid(const Triangles& m, Quat<double> own = {1, 0, 0, 0})
{
    MadeSolid made = SolidMesh::make(m.vertices, m.triangles, own);
    EXPECT_EQ(made.why, "");
    return made.solid;
}
std::string why(const Triangles& m)
{
    return SolidMesh::make(m.vertices, m.triangles, {1, 0, 0, 0}).why;
}

TEST(SolidMesh, OfABoxIsTheBox)
{
    Object o;
    o.shape = ShapeKind::box, o.size = {1, 0.5, 0.25};
    const auto m = solid(box({2, 1, 0.5}));
    EXPECT_NEAR(m->volume(), 0.125, 1e-12);
    EXPECT_EQ(m->file_extent(), 4);
    Draw draw(1);
    for (int i = 0; i < 20000; ++i) {
        const Vec3<double> x{draw.in(-0.55, 0.55), draw.in(-0.3, 0.3), draw.in(-0.2, 0.2)};
        const double d = m->depth(x), exact = depth(o, x);
        EXPECT_EQ(d >= 0, exact >= 0);
        if (exact >= 0) {
            ASSERT_NEAR(d, exact, 1e-9);
        } else {
            ASSERT_GE(d, -2);
        }
    }
}

TEST(SolidMesh, IsADistanceToWavesWithinRounding)
{
    const Triangles waves = ball(40, 0.15);
    const auto m = solid(waves, turn_about(Vec3<double>{0.6, 0, 0.8}, 0.7));
    Draw draw(2);
    int near = 0, steep = 0;
    for (int i = 0; i < 10000; ++i) {
        const Vec3<double> x{draw.in(-0.5, 0.5), draw.in(-0.5, 0.5), draw.in(-0.5, 0.5)};
        const double d = m->depth(x);
        const Vec3<double> other = x + draw.in(0, 0.999) * std::abs(d) * draw.direction();
        ASSERT_EQ(m->depth(other) >= 0, d >= 0);
        if (std::abs(d) > 0.02) continue;
        constexpr double step = 1e-6;
        const auto slope = [&](Vec3<double> along) {
            return (m->depth(x + step * along) - m->depth(x - step * along)) / (2 * step);
        };
        const double g = length(Vec3<double>{slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})});
        ++near, steep += std::abs(g - 1) < 1e-3;
    }
    EXPECT_GT(near, 500);
    EXPECT_GT(steep, 0.97 * near);
}

TEST(SolidMesh, MayBeOfPiecesThatOverlapOrTurnTheirInsideOut)
{
    Triangles two = box({1, 1, 1});
    add(two, box({1, 1, 1}), {1, 0.3, 0.2});
    const auto m = solid(two);
    const double unit = m->file_extent();
    const Vec3<double> middle{0.5, 0.15, 0.1};
    const auto in = [&](Vec3<double> x) { return m->depth((1 / unit) * (x - middle)) >= 0; };
    for (const Vec3<double> x : {Vec3<double>{-0.9, 0, 0}, {0.5, 0.2, 0.1}, {1.9, 0.3, 0.2}})
        EXPECT_TRUE(in(x)) << x.x;
    EXPECT_FALSE(in({1.9, -0.9, 0}));
    EXPECT_FALSE(in({-0.9, 1.2, 0}));
    Triangles apart = box({1, 1, 1});
    add(apart, box({0.5, 0.5, 0.5}), {2, 0, 0}, true);
    EXPECT_NEAR(solid(apart)->volume() * 3.5 * 3.5 * 3.5, 9, 1e-9);
    // A cavity is a piece that faces inwards.
    Triangles hollow = box({1, 1, 1});
    add(hollow, box({0.5, 0.5, 0.5}), {}, true);
    EXPECT_LT(solid(hollow)->depth({0, 0, 0}), -0.2);
    EXPECT_NEAR(solid(hollow)->volume(), 1 - 0.125, 1e-12);
    // Neighbours that are oriented unlike are turned.
    Triangles unlike = ball(12);
    for (std::size_t i = 0; i < unlike.triangles.size(); i += 3)
        std::swap(unlike.triangles[i].x, unlike.triangles[i].y);
    EXPECT_NEAR(solid(unlike)->volume(), solid(ball(12))->volume(), 1e-12);
    EXPECT_EQ(solid(unlike)->closed_holes(), 0u);
}

TEST(SolidMesh, SmallHolesAreClosedAndLargeOnesRefusedWithTheirPlace)
{
    Triangles m = ball(40);
    const double whole = solid(m)->volume();
    const std::size_t all = m.triangles.size();
    m.triangles.erase(m.triangles.begin() + 700, m.triangles.begin() + 702);
    m.triangles.erase(m.triangles.begin() + 3000);
    EXPECT_EQ(solid(m)->closed_holes(), 2u);
    EXPECT_NEAR(solid(m)->volume() / whole, 1, 0.001);
    Draw draw(3);
    const auto holed = solid(m), closed = solid(ball(40));
    for (int i = 0; i < 2000; ++i) {
        const Vec3<double> x = 0.49 * draw.direction();
        EXPECT_EQ(holed->inside(x), closed->inside(x));
    }
    Triangles half = ball(40);
    half.triangles.resize(all / 2);
    const std::string said = why(half);
    EXPECT_NE(said.find("holes of"), std::string::npos) << said;
    EXPECT_NE(said.find("is at ("), std::string::npos) << said;
    Triangles plate;
    plate.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    plate.triangles = {{0, 1, 2}, {0, 2, 3}};
    EXPECT_NE(why(plate).find("100 %"), std::string::npos) << why(plate);
    plate.triangles = {{0, 1, 2}, {0, 2, 1}};
    EXPECT_NE(why(plate), "") << "two sides of a plate";
    plate.vertices.assign(4, {1, 2, 3});
    EXPECT_NE(why(plate), "");
    EXPECT_NE(why({}), "");
}

// A pipe without ends is open, unless they are in other pieces.
TEST(SolidMesh, MayHaveHolesInsideOfOtherPieces)
{
    Triangles pipe;
    constexpr int n = 24;
    for (int k = 0; k < n; ++k)
        for (const double z : {-2.0, 2.0}) {
            const double a = 2 * std::numbers::pi * k / n;
            pipe.vertices.push_back({0.5 * std::cos(a), 0.5 * std::sin(a), z});
        }
    for (int k = 0; k < n; ++k) {
        const int a = 2 * k, b = 2 * ((k + 1) % n);
        pipe.triangles.push_back({a, b, b + 1}), pipe.triangles.push_back({a, b + 1, a + 1});
    }
    EXPECT_NE(why(pipe).find("2)"), std::string::npos) << why(pipe);
    Triangles held = pipe;
    for (const double z : {-2.0, 2.0}) add(held, box({1, 1, 0.7}), {0, 0, z});
    const auto m = solid(held);
    EXPECT_EQ(m->closed_holes(), 2u);
    EXPECT_GT(m->depth({0, 0, 0}), 0.05);
    EXPECT_LT(m->depth({0.15, 0, 0}), 0);
    EXPECT_GT(m->depth({0.15, 0, 0.4}), 0);
}

// Triangles that are drawn at random, with whatever edges they share.
TEST(ClosedSurface, HasNoBorderWhateverItWas)
{
    Draw draw(4);
    for (int round = 0; round < 300; ++round) {
        Triangles m;
        const int vertices = 3 + draw.below(12);
        for (int i = 0; i < vertices; ++i) m.vertices.push_back(draw.vector(1));
        for (int n = 1 + draw.below(30); n > 0; --n)
            m.triangles.push_back(
                {draw.below(vertices), draw.below(vertices), draw.below(vertices)});
        const ClosedSurface closed = closed_surface(m.vertices, m.triangles);
        std::map<std::pair<int, int>, int> balance;
        for (const Int3 t : closed.triangles)
            for (const auto& [a, b] : {std::pair{t.x, t.y}, {t.y, t.z}, {t.z, t.x}})
                balance[{std::min(a, b), std::max(a, b)}] += a < b ? 1 : -1;
        for (const auto& [edge, sum] : balance) ASSERT_EQ(sum, 0) << round;
    }
}

TEST(DepthLattice, HasTheDepthsOfItsSolid)
{
    const auto m = solid(ball(60, 0.1));
    Draw draw(5);
    for (const double wall : {0.0, 0.08}) {
        const double spacing = 0.008;
        const DepthLattice lattice(*m, wall, spacing, 2.5 * spacing);
        double worst = 0;
        for (int i = 0; i < 20000; ++i) {
            const Vec3<double> x{draw.in(-0.55, 0.55), draw.in(-0.55, 0.55), draw.in(-0.55, 0.55)};
            const double exact = m->depth(x, wall), found = lattice.depth(x);
            if (std::abs(exact) < 2 * spacing)
                worst = std::max(worst, std::abs(found - exact));
            else
                ASSERT_EQ(found > 0, exact > 0) << exact;
        }
        EXPECT_LT(worst, 0.3 * spacing) << wall;
    }
}

TEST(SolidMesh, OfAHundredThousandTrianglesIsQuick)
{
    const Triangles waves = ball(160, 0.1);
    EXPECT_GT(waves.triangles.size(), 100000u);
    const auto before = std::chrono::steady_clock::now();
    const auto m = solid(waves);
    const DepthLattice lattice(*m, 0, 0.004, 0.01);
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - before;
    std::cout << passed.count() << " s for " << waves.triangles.size() << " triangles\n";
    EXPECT_GT(lattice.depth({0, 0, 0}), 0);
}

}  // namespace
}  // namespace knead
