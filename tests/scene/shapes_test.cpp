// Shapes of objects: distances, boxes and volumes, what fills them, and what is refused.
#include "host/scene/shapes.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>

#include "host/base/errors.h"
#include "host/base/font_file.h"
#include "host/scene/letters.h"
#include "host/scene/names.h"
#include "host/scene/object_json.h"
#include "host/scene/seed.h"
#include "tests/folder.h"
#include "tests/reason.h"
#include "tests/scene/density_noise.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

constexpr std::size_t room = std::size_t(1) << 33;

// Each shape but that of splats; none is less than 0.25 m across, but for the strokes of the text.
const std::pair<const char*, const char*> all_shapes[] = {
    {"sphere", R"("shape": "sphere", "diameter": 0.46)"},
    {"box", R"("shape": "box", "size": [0.52, 0.28, 0.36])"},
    {"cylinder", R"("shape": "cylinder", "diameter": 0.37, "height": 0.51)"},
    {"ellipsoid", R"("shape": "ellipsoid", "size": [0.57, 0.27, 0.39])"},
    {"rounded_box", R"("shape": "rounded_box", "size": [0.53, 0.31, 0.39], "rounding": 0.09)"},
    {"cone", R"("shape": "cone", "diameter": 0.49, "height": 0.47)"},
    {"capsule", R"("shape": "capsule", "diameter": 0.29, "height": 0.61)"},
    {"torus", R"("shape": "torus", "diameter": 0.71, "tube": 0.26)"},
    {"text", R"("shape": "text", "text": "O", "height": 0.75, "depth": 0.27)"}};

bool has_font() { return !font_file().empty(); }
bool usable(const char* name) { return has_font() || std::string(name) != "text"; }

std::string rotated(const std::string& shape, Quat<double> q)
{
    std::string all = "{" + shape + R"(, "centre": [0.503, 0.497, 0.506], "rotation": [)";
    for (const double part : {q.w, q.x, q.y, q.z})
        all += (all.back() == '[' ? "" : ",") + short_number(part);
    return all + "]}";
}
constexpr Quat<double> upright{1, 0, 0, 0};

// Cells of 1/`cells` m.
Scene scene_of(const std::string& object, int cells)
{
    Scene s = parse_scene(
        R"({"schema": "knead.scene/1", "domain": {"cells": )" + std::to_string(cells) +
            R"(}, "walls": {"min": [0, 0, 0], "max": [1, 1, 1]}, "objects": [)" + object + "]}",
        "scene.json");
    build(s, room);
    return s;
}
Object object_of_text(const std::string& shape, Quat<double> q = upright)
{
    Object found;
    ObjectReader::read(parse_json(rotated(shape, q), "o"), "o", "",
                       [&](ObjectReader& r) { found = read_object(r, ""); });
    return found;
}

TEST(Shapes, AreFilledWithTheirVolume)
{
    Draw draw(1);
    for (const auto& [name, shape] : all_shapes) {
        if (!usable(name)) continue;
        for (int i = 0; i < 4; ++i) {
            const Quat<double> q =
                i == 0 ? upright : turn_about(draw.direction(), draw.in(0, 2 * std::numbers::pi));
            const Scene s = scene_of(rotated(shape, q), 40);
            const double volume = double(s.setup.particles.size()) * s.setup.materials[0].volume,
                         exact = shape_volume(s.objects[0]);
            EXPECT_NEAR(volume / exact, 1, 0.002) << name << " " << i;
            if (std::getenv("KNEAD_PRINT"))
                std::cout << name << " " << i << ": " << 100 * (volume / exact - 1) << " %, "
                          << s.setup.particles.size() << " particles\n";
            // A whole stratum at a reflex corner may have its particle just outside.
            const bool smooth = std::string(name) != "text";
            for (const Particle<double>& p : s.setup.particles)
                ASSERT_GE(depth(s.objects[0], p.x), smooth ? 0 : -1e-3) << name;
        }
    }
}

TEST(Shapes, AreFilledEvenly)
{
    const Quat<double> turned = turn_about(Vec3<double>{0.6, 0, 0.8}, 0.7);
    for (const auto& [name, shape] : all_shapes) {
        if (!usable(name)) continue;
        for (const Quat<double> q : {upright, turned}) {
            const double noise = density_noise(scene_of(rotated(shape, q), 48));
            EXPECT_LE(noise, 0.006) << name;
            if (std::getenv("KNEAD_PRINT"))
                std::cout << name << ": " << 100 * noise << " % of noise\n";
        }
    }
}

// No point nearer than the depth is on the other side; across the surface the depth changes as the
// place does.
TEST(Shapes, HaveADepthThatIsADistance)
{
    Draw draw(3);
    for (const auto& [name, shape] : all_shapes) {
        if (!usable(name)) continue;
        const Object o = object_of_text(shape, turn_about(draw.direction(), 1.1));
        const Vec3<double> half = 0.5 * extents(o), middle = middle_of(o);
        int near = 0, steep = 0;
        for (int i = 0; i < 40000; ++i) {
            const Vec3<double> x =
                middle + 1.1 * Vec3<double>{half.x * draw.in(-1, 1), half.y * draw.in(-1, 1),
                                            half.z * draw.in(-1, 1)};
            const double d = depth(o, x);
            const Vec3<double> other = x + draw.in(0, 0.999) * std::abs(d) * draw.direction();
            ASSERT_EQ(depth(o, other) >= 0, d >= 0) << name << " at depth " << d;
            if (std::abs(d) > 0.01) continue;
            constexpr double step = 1e-6;
            const auto slope = [&](Vec3<double> along) {
                return (depth(o, x + step * along) - depth(o, x - step * along)) / (2 * step);
            };
            const double g =
                length(Vec3<double>{slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})});
            ++near, steep += std::abs(g - 1) < 1e-3;
        }
        EXPECT_GT(near, 500) << name;
        EXPECT_GT(steep, 0.97 * near) << name;
    }
}

TEST(Shapes, FitTheirBox)
{
    Draw draw(4);
    for (const auto& [name, shape] : all_shapes) {
        if (!usable(name)) continue;
        for (int turn = 0; turn < 4; ++turn) {
            const Object o = object_of_text(
                shape, turn == 0 ? upright : turn_about(draw.direction(), draw.in(0, 6)));
            const Box3<double> box = box_of(o);
            const Vec3<double> size = box.high - box.low;
            Box3<double> found = empty_box<double>();
            const int n = 60;
            for (int i = 0; i < n * n * n; ++i) {
                const Vec3<double> part{(i % n + 0.5) / n, (i / n % n + 0.5) / n,
                                        (i / (n * n) + 0.5) / n};
                const Vec3<double> x = box.low + Vec3<double>{size.x * (1.4 * part.x - 0.2),
                                                              size.y * (1.4 * part.y - 0.2),
                                                              size.z * (1.4 * part.z - 0.2)};
                if (inside(o, x)) grow(found, x);
            }
            const auto fits = [&](double low, double high, double from, double to,
                                  const char* axis) {
                EXPECT_GE(from, low - 1e-9) << name << " " << axis;
                EXPECT_LE(to, high + 1e-9) << name << " " << axis;
                // The apex of a cone is thin.
                const double within = 0.09 * (high - low);
                EXPECT_NEAR(from, low, within) << name << " " << axis;
                EXPECT_NEAR(to, high, within) << name << " " << axis;
            };
            fits(box.low.x, box.high.x, found.low.x, found.high.x, "x");
            fits(box.low.y, box.high.y, found.low.y, found.high.y, "y");
            fits(box.low.z, box.high.z, found.low.z, found.high.z, "z");
        }
    }
}

TEST(Shapes, HaveTheVolumeOfTheirInside)
{
    for (const auto& [name, shape] : all_shapes) {
        if (!usable(name)) continue;
        const Object o = object_of_text(shape);
        const Box3<double> box = box_of(o);
        const Vec3<double> size = box.high - box.low;
        const int n = 160;
        int count = 0;
        for (int z = 0; z < n; ++z)
            for (int y = 0; y < n; ++y)
                for (int x = 0; x < n; ++x)
                    count += inside(
                        o, box.low + Vec3<double>{size.x * (x + 0.5) / n, size.y * (y + 0.5) / n,
                                                  size.z * (z + 0.5) / n});
        const double share = double(count) / n / n / n * size.x * size.y * size.z;
        EXPECT_NEAR(share / shape_volume(o), 1, 0.003) << name;
    }
}

TEST(Shapes, OfExtremeProportionsAreDistances)
{
    Draw draw(5);
    for (const char* shape :
         {R"("shape": "ellipsoid", "size": [1, 0.001, 0.3])",
          R"("shape": "ellipsoid", "size": [0.5, 0.5, 0.5])",
          R"("shape": "ellipsoid", "size": [0.001, 900, 0.001])",
          R"("shape": "capsule", "diameter": 0.3, "height": 0.3)",
          R"("shape": "rounded_box", "size": [0.2, 0.2, 0.2], "rounding": 0.1)",
          R"("shape": "rounded_box", "size": [0.2, 0.2, 0.2], "rounding": 0)"}) {
        const Object o = object_of_text(shape);
        EXPECT_NEAR(depth(o, o.centre), std::min({o.size.x, o.size.y, o.size.z}) / 2,
                    1e-7 * o.size.y)
            << shape;
        for (int i = 0; i < 2000; ++i) {
            const Vec3<double> x =
                o.centre + Vec3<double>{o.size.x * draw.in(-1, 1), o.size.y * draw.in(-1, 1),
                                        o.size.z * draw.in(-1, 1)};
            const double d = depth(o, x);
            ASSERT_TRUE(std::isfinite(d)) << shape;
            const Vec3<double> other = x + draw.in(0, 0.999) * std::abs(d) * draw.direction();
            ASSERT_EQ(depth(o, other) >= 0, d >= 0) << shape;
        }
    }
}

std::vector<Point2> square(double low, double high, double up = 0)
{
    return {{low, low + up}, {high, low + up}, {high, high + up}, {low, high + up}};
}

TEST(Letters, AreTheUnionOfOutlinesByWinding)
{
    std::vector<Point2> hole = square(1, 2);
    std::reverse(hole.begin(), hole.end());
    const Letters ring({square(0, 3), hole});
    EXPECT_DOUBLE_EQ(ring.area(), 8);
    EXPECT_NEAR(ring.depth({0, 0}), -0.5, 1e-12);
    EXPECT_NEAR(ring.depth({1, 0}), 0.5, 1e-12);
    EXPECT_NEAR(ring.depth({1.9, 1.9}), -std::hypot(0.4, 0.4), 1e-12);
    // Two squares that overlap, on a common line below and not.
    const Letters two({square(0, 2), {{1, 0}, {3, 0}, {3, 2}, {1, 2}}});
    EXPECT_NEAR(two.area(), 6, 1e-9);
    EXPECT_DOUBLE_EQ(two.width(), 3);
    EXPECT_NEAR(two.depth({0.5, 0}), 1, 1e-9) << "no edge inside";
    const Letters cross({{{0, 1}, {3, 1}, {3, 2}, {0, 2}}, {{1, 0}, {2, 0}, {2, 3}, {1, 3}}});
    EXPECT_NEAR(cross.area(), 5, 1e-9);
    EXPECT_NEAR(cross.depth({0, 0}), std::hypot(0.5, 0.5), 1e-9);
    EXPECT_NEAR(cross.depth({1, 1}), -0.5, 1e-9);
    // One beside the other; the same twice.
    EXPECT_NEAR(Letters({square(0, 1), {{1, 0}, {2, 0}, {2, 1}, {1, 1}}}).depth({0, 0}), 0.5, 1e-9);
    EXPECT_NEAR(Letters({square(0, 1), square(0, 1)}).area(), 1, 1e-9);
    EXPECT_EQ(Letters({}).area(), 0);
}

std::string fault(const std::string& text) { return letters_of(text).why; }

TEST(Letters, AreThoseOfTheFont)
{
    if (!has_font()) GTEST_SKIP() << fault("a");
    const auto of = [](const std::string& text) { return letters_of(text).letters; };
    EXPECT_NEAR(of("H")->height(), 1, 1e-9);
    EXPECT_GT(of("Hg")->height(), 1.1);
    EXPECT_LT(of("o")->depth({0, 0}), 0) << "its counter";
    EXPECT_GT(of("o")->depth({-0.45 * of("o")->width(), 0}), 0);
    // From left to right, upright.
    const auto foot = of("L");
    EXPECT_GT(foot->depth({0.4 * foot->width(), -0.45}), 0);
    EXPECT_LT(foot->depth({0.4 * foot->width(), 0.2}), 0);
    EXPECT_GT(foot->depth({-0.4 * foot->width(), 0.2}), 0);
    const auto word = of("il");
    EXPECT_LT(word->depth({-0.45 * word->width(), 0.26}), 0) << "between dot and stem";
    // Kerning.
    const double apart = of("A|V")->width() - of("|")->width();
    EXPECT_LT(of("AV")->width(), apart);
    // Lines are below each other, centred.
    const auto lines = of("HHH\nI");
    EXPECT_GT(lines->height(), 2.2);
    EXPECT_NEAR(lines->width(), of("HHH")->width(), 1e-9);
    EXPECT_GT(lines->depth({0, -0.45 * lines->height()}), 0);
    EXPECT_NEAR(of("\xc3\x84")->height(), of("\xc3\x84")->height(), 0);
    EXPECT_EQ(of("knead"), of("knead"));
}

TEST(Letters, SayWhyThereAreNone)
{
    EXPECT_EQ(fault(""), "no text");
    EXPECT_EQ(fault(std::string(65, 'a')), "65 characters, more than 64");
    EXPECT_EQ(glyph_outlines("a", "").fault.substr(0, 7), "no font");
    if (!has_font()) GTEST_SKIP() << fault("a");
    EXPECT_EQ(fault(std::string(64, 'a')), "");
    EXPECT_EQ(fault(" \n  "), "blanks alone");
    EXPECT_NE(fault("a\xf0\x9f\xa6\x84"
                    "b\x07")
                  .find("lacks: U+1F984, U+0007"),
              std::string::npos)
        << fault(
               "a\xf0\x9f\xa6\x84"
               "b\x07");
    EXPECT_NE(glyph_outlines("a", "scenes/squeeze.json").fault, "");
}

TEST(Letters, OfAFileThatEndsInsideATableAreRefused)
{
    if (!has_font()) GTEST_SKIP() << fault("a");
    const std::string whole = font_bytes(font_file());
    const Folder folder;
    const std::string file = folder / "part.ttf";
    const auto refused = [&](const std::string& bytes) {
        std::ofstream(file, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
        return font_bytes(file).empty() && !glyph_outlines("a", file).fault.empty();
    };
    for (const std::size_t size : {0, 3, 12, 40, 4096}) EXPECT_TRUE(refused(whole.substr(0, size)));
    EXPECT_TRUE(refused(whole.substr(0, whole.size() - 4096)));
    std::string tables = whole;  // more of them than the file holds
    tables[4] = tables[5] = '\xff';
    EXPECT_TRUE(refused(tables));
    EXPECT_FALSE(refused(whole));
}

std::string refusal(const std::string& shape)
{
    return reason<InputError>([&] { object_of_text(shape); });
}

TEST(Shapes, ThatCannotBeAreRefusedByTheirKey)
{
    const struct {
        const char *shape, *place, *what;
    } all[] = {
        {R"("shape": "torus", "diameter": 0.4, "tube": 0.2)", "/tube", "less than half the diam"},
        {R"("shape": "torus", "diameter": 0.4)", "/tube", ""},
        {R"("shape": "torus", "diameter": 0, "tube": 0.1)", "/diameter", "above 0"},
        {R"("shape": "torus", "diameter": 0.4, "tube": -1)", "/tube", "above 0"},
        {R"("shape": "torus", "diameter": 1e300, "tube": 1)", "/diameter", "at most 1000"},
        {R"("shape": "capsule", "diameter": 0.4, "height": 0.39)", "/height", "the diameter"},
        {R"("shape": "capsule", "diameter": 0.4)", "/height", ""},
        {R"("shape": "cone", "diameter": 0.4, "height": 0)", "/height", "above 0"},
        {R"("shape": "cone", "diameter": null, "height": 1)", "/diameter", ""},
        {R"("shape": "ellipsoid", "size": [1, 0, 1])", "/size", "above 0"},
        {R"("shape": "ellipsoid", "diameter": 1)", "/size", ""},
        {R"("shape": "rounded_box", "size": [1, 1, 0.2], "rounding": 0.11)", "/rounding", "0.1 m"},
        {R"("shape": "rounded_box", "size": [1, 1, 1], "rounding": -0.1)", "/rounding", ""},
        {R"("shape": "rounded_box", "size": [1, 1, 2000])", "/size", "at most 1000"},
        {R"("shape": "box", "size": [1, 1, 1], "rounding": 0.1)", "/rounding", ""},
        {R"("shape": "text", "text": "", "height": 0.1, "depth": 0.1)", "/text", "no text"},
        {R"("shape": "text", "height": 0.1, "depth": 0.1)", "/text", ""},
        {R"("shape": "text", "text": 3, "height": 0.1, "depth": 0.1)", "/text", ""},
        {R"("shape": "text", "text": "a", "height": 0, "depth": 0.1)", "/height", "above 0"},
        {R"("shape": "text", "text": "a", "height": 0.1, "depth": 1e9)", "/depth", ""},
        {R"("shape": "text", "text": "  ", "height": 0.1, "depth": 0.1)", "/text", ""}};
    for (const auto& one : all) {
        const std::string found = refusal(one.shape);
        EXPECT_NE(found.find(one.place), std::string::npos) << one.shape << ": " << found;
        EXPECT_NE(found.find(one.what), std::string::npos) << one.shape << ": " << found;
    }
    if (has_font()) {
        EXPECT_NE(refusal(R"("shape": "text", "text": "ab", "height": 900, "depth": 0.1)")
                      .find("/height"),
                  std::string::npos);
    }
    EXPECT_EQ(object_of_text(R"("shape": "rounded_box", "size": [1, 0.4, 2])").rounding, 0.1);
}

// With KNEAD_PRINT: the time to fill about a million particles.
TEST(Shapes, AreFilledInTime)
{
    const bool prints = std::getenv("KNEAD_PRINT");
    const int cells = prints ? 124 : 32;
    for (const char* shape :
         {R"("shape": "sphere", "diameter": 0.5)",
          R"("shape": "torus", "diameter": 0.8, "tube": 0.2)",
          R"("shape": "text", "text": "knead", "height": 0.24, "depth": 0.3)"}) {
        if (!usable("text") && std::string(shape).find("text") < 12) continue;
        Scene s = scene_of(rotated(shape, upright), 32);
        s.setup.lattice = {{cells, cells, cells}, 1.0 / cells};
        const auto start = std::chrono::steady_clock::now();
        build(s, room);
        const double took =
            std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        EXPECT_LT(took, 60);
        if (prints)
            std::cout << shape << ": " << s.setup.particles.size() << " particles in " << took
                      << " s\n";
    }
}

}  // namespace
}  // namespace knead
