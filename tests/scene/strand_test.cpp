// Strands: layers of particles along a path, their volume and density, and what is refused.
#include "host/scene/strand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "host/base/errors.h"
#include "host/scene/names.h"
#include "host/scene/seed.h"
#include "tests/reason.h"

namespace knead {
namespace {

constexpr double pi = std::numbers::pi;

Scene built(const std::string& object)
{
    Scene s = parse_scene(
        R"({"schema": "knead.scene/1", "domain": {"cells": 32},
            "walls": {"min": [0, 0, 0], "max": [1, 1, 1]}, )" +
            object + "}",
        "scene.json");
    build(s, std::size_t(1) << 33);
    return s;
}

Strand straight(SectionKind section, double diameter, Vec3<double> to)
{
    Strand s{section, diameter, {}, {{}, {to, {}}}, false};
    if (section == SectionKind::outline)
        s.outline = {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 2}, {0, 2}};
    return s;
}

double area(SectionKind section, double d)
{
    const double inner = std::sin(pi / 5) / 2;  // of a tenth of a star of radius 1, times 2
    const double width = 2 * std::sin(2 * pi / 5);
    switch (section) {
        case SectionKind::square:
            return d * d;
        case SectionKind::star:
            return 10 * inner / 2 * d * d / (width * width);
        case SectionKind::outline:
            return 4 * d * d / 9;
        case SectionKind::circle:
            break;
    }
    return pi * d * d / 4;
}

TEST(Strands, HaveTheVolumeOfTheirSectionTimesTheirLength)
{
    for (const auto& [name, section] : section_kinds)
        for (const Vec3<double> to : {Vec3<double>{0.4, 0, 0}, {-0.1, 0.3, 0.2}, {0, -0.5, 0}})
            for (const double h : {0.004, 0.0063, 0.01}) {
                const Strand s = straight(section, 0.07, to);
                const double exact = area(section, 0.07) * length(to);
                EXPECT_NEAR(laid_volume(s), exact, 1e-9 * exact) << name;
                const double made = double(laid(s, h).size()) * h * h * h;
                // The number of layers is whole.
                EXPECT_NEAR(made, exact, 0.51 * h / length(to) * 1.1 * exact) << name << " " << h;
            }
}

TEST(Strands, KeepTheirParticlesApartAndInTheirSection)
{
    for (const auto& [name, section] : section_kinds) {
        const double h = 0.005;
        const Strand s = straight(section, 0.08, {0.1, 0, 0});
        const std::vector<Vec3<double>> all = laid(s, h);
        double nearest = 1;
        for (std::size_t i = 0; i < all.size(); ++i) {
            EXPECT_LE(distance_from(s, all[i]), reach_of(s));
            EXPECT_TRUE(all[i].x > 0 && all[i].x < 0.1);
            for (std::size_t k = 0; k < i; ++k)
                nearest = std::min(nearest, length(all[i] - all[k]));
        }
        EXPECT_GT(nearest, 0.6 * h) << name;
    }
}

// However a path is divided, and whatever follows.
TEST(Strands, AreLaidPieceByPieceAsAtOnce)
{
    Strand whole{SectionKind::square, 0.05, {}, {}, false};
    for (int i = 0; i <= 200; ++i) {
        const double a = 0.03 * i;
        whole.path.push_back({{0.2 * std::cos(a), 0.001 * i, 0.2 * std::sin(a)}, {0, 1, 0}});
    }
    const std::vector<Vec3<double>> at_once = laid(whole, 0.006);
    Strand part = whole;
    part.path.resize(1);
    std::vector<Vec3<double>> pieces;
    for (std::size_t i = 1; i < whole.path.size(); ++i) {
        part.path.push_back(whole.path[i]);
        for (const Vec3<double>& x : laid(part, 0.006, i)) pieces.push_back(x);
    }
    ASSERT_EQ(pieces.size(), at_once.size());
    for (std::size_t i = 0; i < pieces.size(); ++i)
        EXPECT_EQ(length(pieces[i] - at_once[i]), 0) << i;
}

// Pappus: area times the way of the middle.
TEST(Strands, AroundACircleHaveTheVolumeOfATorus)
{
    Strand s{SectionKind::circle, 0.06, {}, {}, false};
    for (int i = 0; i <= 720; ++i) {
        const double a = 2 * pi * i / 720;
        s.path.push_back({{0.2 * std::cos(a), 0, 0.2 * std::sin(a)}, {}});
    }
    const double torus = 2 * pi * 0.2 * pi * 0.03 * 0.03;
    EXPECT_NEAR(laid_volume(s), torus, 1e-3 * torus);
    double farthest = 0;
    for (const Vec3<double>& x : laid(s, 0.005))
        farthest = std::max(farthest, std::hypot(std::hypot(x.x, x.z) - 0.2, x.y));
    EXPECT_LT(farthest, 0.03 + 0.0005);
}

// Where the axis is beside the motion, the section faces along it; elsewhere along the motion.
TEST(Strands, FaceAlongTheNozzleWithin45Degrees)
{
    const auto volume = [](Vec3<double> axis) {
        Strand s{SectionKind::circle, 0.05, {}, {{{}, axis}, {{0.3, 0, 0}, axis}}, false};
        return laid_volume(s) / (area(SectionKind::circle, 0.05) * 0.3);
    };
    EXPECT_NEAR(volume({1, 0, 0}), 1, 1e-9);
    EXPECT_NEAR(volume({-2, 0, 0}), 1, 1e-9);
    EXPECT_NEAR(volume({0, 1, 0}), 1, 1e-9);
    EXPECT_NEAR(volume({std::cos(0.5), std::sin(0.5), 0}), std::cos(0.5), 1e-9);
    EXPECT_NEAR(volume({-std::cos(0.5), 0, std::sin(0.5)}), std::cos(0.5), 1e-9);
    EXPECT_NEAR(volume({std::cos(0.8), std::sin(0.8), 0}), 1, 1e-9);
}

TEST(Strands, OfSharpCornersAndOfWaysBackAreLaidToTheirEnd)
{
    for (const Vec3<double> then : {Vec3<double>{0.2, 0.3, 0}, {0, 0, 0}, {0.2, 0, -0.3}}) {
        const Strand s{SectionKind::square, 0.04, {}, {{}, {{0.2, 0, 0}, {}}, {then, {}}}, false};
        const std::vector<Vec3<double>> all = laid(s, 0.005);
        double nearest = 1;
        for (const Vec3<double>& x : all) nearest = std::min(nearest, length(x - then));
        EXPECT_LT(nearest, 0.01);
        for (const Vec3<double>& x : all) EXPECT_LE(distance_from(s, x), reach_of(s));
        // Without a gap: layers of 64 particles, their middles no more than 2 layers apart.
        const std::size_t layer = 64;
        ASSERT_EQ(all.size() % layer, 0u);
        Vec3<double> before{};
        for (std::size_t from = 0; from < all.size(); from += layer) {
            Vec3<double> middle{};
            for (std::size_t i = 0; i < layer; ++i) middle = middle + 1.0 / layer * all[from + i];
            EXPECT_LT(length(middle - before), 0.0101);
            before = middle;
        }
    }
}

// The clay of a strand in a scene, on a lattice of cubes of its own.
TEST(Strands, OfAScenePackAsEvenlyAsTheirLayers)
{
    const Scene scene = built(R"("objects": [{"shape": "strand", "section": "square",
        "diameter": 0.2, "centre": [0.3, 0.5, 0.5], "path": [[0, 0, 0], [0.4, 0, 0]]}])");
    const double dx = scene.setup.lattice.dx, particle = scene.setup.materials[0].volume;
    std::map<std::array<int, 3>, double> cells;
    for (const Particle<double>& p : scene.setup.particles)
        cells[{int(p.x.x / dx), int(p.x.y / dx), int(p.x.z / dx)}] += particle / (dx * dx * dx);
    double most = 0;
    for (const auto& [cell, density] : cells) most = std::max(most, density);
    EXPECT_LT(most, 1.6);
    EXPECT_NEAR(double(scene.setup.particles.size()) * particle, 0.016, 0.0004);
}

TEST(Strands, ThatCannotBeAreRefused)
{
    const auto why = [](const std::string& keys) {
        return reason<InputError>([&] {
            built(R"("objects": [{"shape": "strand", "centre": [0.3, 0.5, 0.5], )" + keys + "}]");
        });
    };
    EXPECT_EQ(why(R"("diameter": 0.1, "path": [[0, 0, 0], [0.2, 0, 0]])"), "");
    const std::pair<const char*, const char*> all[] = {
        {R"("diameter": 0.1)", "/path"},
        {R"("diameter": 0.1, "path": [])", "/path"},
        {R"("diameter": 0.1, "path": [[0, 0]])", "/path"},
        {R"("diameter": 0.1, "path": [[0, 0, 1e9]])", "/path"},
        {R"("diameter": 0.1, "path": [[0, 0, 0]])", "holds particles"},
        {R"("diameter": 0.1, "path": [[0, 0, 0], [0, 0, 0]])", "holds particles"},
        {R"("diameter": 1e-6, "path": [[0, 0, 0], [0.2, 0, 0]])", "10000 diameters"},
        {R"("diameter": 0, "path": [[0, 0, 0], [0.2, 0, 0]])", "/diameter"},
        {R"("diameter": 0.1, "section": "moon", "path": [[0, 0, 0], [0.2, 0, 0]])", "/section"},
        {R"("diameter": 0.1, "section": "outline", "path": [[0, 0, 0], [0.2, 0, 0]])", "/outline"},
        {R"("diameter": 0.1, "section": "outline", "outline": [[0, 0], [1, 1], [2, 2]],)"
         R"("path": [[0, 0, 0], [0.2, 0, 0]])",
         "an area"},
        {R"("diameter": 0.1, "outline": [[0, 0], [1, 1], [2, 0]],)"
         R"("path": [[0, 0, 0], [0.2, 0, 0]])",
         "/outline"},
        {R"("diameter": 0.1, "axes": [[0, 0, 1]], "path": [[0, 0, 0], [0.2, 0, 0]])", "/axes"},
        {R"("diameter": 900, "path": [[0, 0, 0], [1e-9, 0, 0]])", "section of at most"}};
    for (const auto& [keys, what] : all)
        EXPECT_NE(why(keys).find(what), std::string::npos) << keys << ": " << why(keys);
}

}  // namespace
}  // namespace knead
