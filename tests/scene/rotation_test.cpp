// Rotated objects: volume, mass, box and place of their particles.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/base/errors.h"
#include "host/scene/seed.h"
#include "tests/reason.h"
#include "tests/solver/samples.h"

namespace knead {
namespace {

constexpr std::size_t room = std::size_t(1) << 32;

Scene scene_of(const std::string& object, const std::vector<std::string>& settings = {})
{
    Scene s = parse_scene(R"({"schema": "knead.scene/1", "domain": {"cells": 32},
        "walls": {"min": [0, 0, 0], "max": [1, 1, 1]}, "objects": [)" +
                              object + "]}",
                          "scene.json", settings);
    build(s, room);
    return s;
}
const std::string box =
    R"({"shape": "box", "centre": [0.5, 0.5, 0.5], "size": [0.5, 0.25, 0.125], "rotation": )";
const std::string cylinder =
    R"({"shape": "cylinder", "centre": [0.5, 0.5, 0.5], "diameter": 0.3, "height": 0.5,
        "rotation": )";

std::string text(Quat<double> q)
{
    std::string all;
    for (const double part : {q.w, q.x, q.y, q.z})
        all += (all.empty() ? "[" : ",") + std::to_string(part);
    return all + "]";
}
Quat<double> drawn_rotation(Draw& draw)
{
    return turn_about(draw.direction(), draw.in(0, 2 * std::numbers::pi));
}

Box3<double> box_of_particles(const Scene& s)
{
    Box3<double> all = empty_box<double>();
    for (const Particle<double>& p : s.setup.particles) grow(all, p.x);
    return all;
}

TEST(RotatedObjects, HoldTheirVolumeAndMassWithinTheirBox)
{
    Draw draw(1);
    for (const std::string& shape : {box, cylinder})
        for (int i = 0; i < 6; ++i) {
            const Quat<double> q = drawn_rotation(draw);
            const Scene s = scene_of(shape + text(q) + "}");
            const Object& o = s.objects[0];
            const double volume = double(s.setup.particles.size()) * s.setup.materials[0].volume;
            EXPECT_NEAR(volume, shape_volume(o), 5e-3 * shape_volume(o)) << text(q);
            const double mass = double(s.setup.particles.size()) * s.setup.materials[0].mass;
            EXPECT_NEAR(mass, 1700 * shape_volume(o), 5e-3 * 1700 * shape_volume(o));
            const Box3<double> is = box_of_particles(s), wanted = box_of(o);
            const double h = s.setup.lattice.dx / 2;
            for (const Particle<double>& p : s.setup.particles) {
                ASSERT_TRUE(inside(o, p.x));
                ASSERT_TRUE(contains(expanded(wanted, 1e-12), p.x));
            }
            // The outermost particles are at corners and edges, which hold less than a stratum.
            EXPECT_LT(length(is.low - wanted.low), 3 * h) << text(q);
            EXPECT_LT(length(is.high - wanted.high), 3 * h) << text(q);
            Vec3<double> middle{};
            for (const Particle<double>& p : s.setup.particles) middle = middle + p.x;
            middle = (1 / double(s.setup.particles.size())) * middle;
            EXPECT_LT(length(middle - o.centre), 0.1 * h);
        }
}

// A point of the surface in the object's frame, of unit lengths: corners, rims, or anywhere.
Vec3<double> drawn_extreme(ShapeKind shape, Draw& draw)
{
    const auto sign = [&] { return draw.below(2) ? 1.0 : -1.0; };
    if (shape == ShapeKind::sphere) return draw.direction();
    if (shape == ShapeKind::box) return {sign(), sign(), sign()};
    const double angle = draw.in(0, 2 * std::numbers::pi);
    return {std::cos(angle), sign(), std::sin(angle)};
}

TEST(RotatedObjects, TheBoxContainsTheShapeAndTouchesIt)
{
    Draw draw(2);
    for (const ShapeKind shape : {ShapeKind::box, ShapeKind::cylinder, ShapeKind::sphere})
        for (int i = 0; i < 20; ++i) {
            Object o;
            o.shape = shape, o.centre = {1, 2, 3}, o.rotation = drawn_rotation(draw);
            o.size = shape == ShapeKind::box        ? Vec3<double>{2, 1, 0.5}
                     : shape == ShapeKind::cylinder ? Vec3<double>{2, 1, 2}
                                                    : Vec3<double>{2, 2, 2};
            Box3<double> seen = empty_box<double>();
            for (int k = 0; k < 20000; ++k) {
                const Vec3<double> d = drawn_extreme(shape, draw);
                const Vec3<double> at{d.x * o.size.x / 2, d.y * o.size.y / 2, d.z * o.size.z / 2};
                const Vec3<double> x = o.centre + rotate(o.rotation, at);
                ASSERT_NEAR(depth(o, x), 0, 1e-12);
                grow(seen, x);
            }
            const Box3<double> found = box_of(o);
            EXPECT_LT(length(found.low - seen.low), 1e-3);
            EXPECT_LT(length(found.high - seen.high), 1e-3);
            ASSERT_TRUE(contains(expanded(found, 1e-12), seen.low));
            ASSERT_TRUE(contains(expanded(found, 1e-12), seen.high));
        }
}

TEST(RotatedObjects, ABoxOnItsSideIsTheBoxWithItsEdgesExchanged)
{
    Object lying, plain;
    lying.shape = plain.shape = ShapeKind::box;
    lying.size = {2, 1, 1}, plain.size = {1, 2, 1};
    lying.rotation = turn_about({0, 0, 1}, std::numbers::pi / 2);
    EXPECT_LT(length(extents(lying) - extents(plain)), 1e-15);
    const std::string quarter = text(lying.rotation);
    const Scene a = scene_of(R"({"shape": "box", "centre": [0.5, 0.5, 0.5],
                                 "size": [0.5, 0.25, 0.25], "rotation": )" +
                             quarter + "}"),
                b = scene_of(R"({"shape": "box", "centre": [0.5, 0.5, 0.5],
                                 "size": [0.25, 0.5, 0.25]})");
    EXPECT_EQ(b.setup.particles.size(), 16u * 8 * 8 * 8);
    EXPECT_NEAR(double(a.setup.particles.size()), 16 * 8 * 8 * 8, 8);
    const Box3<double> one = box_of_particles(a), two = box_of_particles(b);
    EXPECT_LT(length(one.low - two.low), 0.2 * a.setup.lattice.dx);
    EXPECT_LT(length(one.high - two.high), 0.2 * a.setup.lattice.dx);
}

TEST(RotatedObjects, NoRotationChangesNoBit)
{
    for (const std::string& shape : {box, cylinder}) {
        const std::string plain = shape.substr(0, shape.rfind(','));
        const Scene a = scene_of(plain + "}"), b = scene_of(shape + "[1, 0, 0, 0]}");
        ASSERT_EQ(a.setup.particles.size(), b.setup.particles.size());
        for (std::size_t i = 0; i < a.setup.particles.size(); ++i) {
            const Vec3<double> x = a.setup.particles[i].x, y = b.setup.particles[i].x;
            ASSERT_TRUE(x.x == y.x && x.y == y.y && x.z == y.z);
        }
        EXPECT_EQ(length(extents(a.objects[0]) - a.objects[0].size), 0);
    }
}

TEST(RotatedObjects, MustLieBetweenTheWalls)
{
    const std::string wide = R"({"shape": "box", "centre": [0.5, 0.5, 0.5],
                                 "size": [0.9, 0.9, 0.1], "rotation": )";
    EXPECT_EQ(reason<InputError>([&] { scene_of(wide + "[1, 0, 0, 0]}"); }), "");
    const std::string said = reason<InputError>([&] {
        scene_of(wide + text(turn_about({0, 0, 1}, std::numbers::pi / 4)) + "}");
    });
    EXPECT_NE(said.find("expected the object between the walls, x from 0 to 1 m, found x from "
                        "-0.136396 to 1.1364 m"),
              std::string::npos)
        << said;
}

TEST(RotatedObjects, TakeTheirSpaceFromLaterOnes)
{
    const std::string q = text(turn_about({0, 0, 1}, std::numbers::pi / 4));
    const Scene s = scene_of(box + q + R"(}, {"shape": "box", "centre": [0.5, 0.5, 0.5],
                                               "size": [0.6, 0.6, 0.25]})");
    for (const Particle<double>& p : s.setup.particles)
        ASSERT_EQ(inside(s.objects[0], p.x), p.object == 0);
}

}  // namespace
}  // namespace knead
