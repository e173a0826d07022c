// Photographed objects in scenes: read, placed, filled.
#include "host/assets/splat_object.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "host/assets/procedural_object.h"
#include "host/base/errors.h"
#include "host/scene/seed.h"
#include "host/splats/deformed.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {

class SplatObjects : public testing::Test {
  protected:
    void SetUp() override { write_splats(folder / "pot.splat", glazed_pot(4000)); }

    std::string scene(const std::string& object, const std::string& more = "") const
    {
        const std::string path = folder / "scene.json";
        std::ofstream(path) << R"({"schema": "knead.scene/1", "domain": {"edge": 0.6, "cells": 32},
            "objects": [{"shape": "splats", "file": "pot.splat", "size": 0.3, "up": "y",
                         "centre": [0.3, 0.25, 0.3])"
                            << object << "}" << more << "]}";
        return path;
    }
    Folder folder;
};

constexpr std::size_t room = std::size_t(1) << 32;

TEST_F(SplatObjects, StandWhereTheSceneSaysAndHoldTheVolumeOfTheirSolid)
{
    Scene s = read_scene(scene(""));
    const std::vector<SplatObject> objects = load_splats(s, room);
    ASSERT_EQ(objects.size(), 1u);
    build(s, room);
    const Object& o = s.objects[0];
    EXPECT_NEAR(max(o.size.x, max(o.size.y, o.size.z)), 0.3, 0.02);
    EXPECT_LT(length(o.centre - Vec3<double>{0.3, 0.25, 0.3} + s.origin), 0.02);
    // The pot's own volume, scaled: its longest extent is its width.
    double low = 1e30, high = -1e30;
    for (const Vec3<float>& x : glazed_pot(4000).centre)
        low = std::fmin(low, x.x), high = std::fmax(high, x.x);
    const double scale = 0.3 / (high - low);
    EXPECT_NEAR(shape_volume(o) / (glazed_pot_volume() * scale * scale * scale), 1, 0.05);
    EXPECT_EQ(s.setup.particles.size(), o.given->particles.size());
    EXPECT_EQ(s.setup.gaussians.size(), objects[0].cloud.count());
    EXPECT_GE(objects[0].surface, 3900u);
    EXPECT_GT(objects[0].cloud.count(), objects[0].surface) << "nothing was put inside";
    for (std::size_t i = 0; i < s.setup.gaussians.size(); ++i)
        ASSERT_LT(length(s.setup.gaussians[i].x - cast<double>(objects[0].cloud.centre[i])), 1e-12);
}

TEST_F(SplatObjects, OfFaintSplatsAloneAreRefusedInThoseWords)
{
    SplatCloud faint = glazed_pot(500);
    std::fill(faint.opacity.begin(), faint.opacity.end(), 0.015f);
    write_splats(folder / "pot.splat", faint);
    Scene s = read_scene(scene(""));
    const std::string text = reason<InputError>([&] { load_splats(s, room); });
    EXPECT_NE(text.find("500 splats, all fainter than an opacity of 0.02"), std::string::npos)
        << text;
}

// What the reading dropped and noted comes with the object.
TEST_F(SplatObjects, TellWhatWasDroppedOnReading)
{
    SplatCloud cloud = glazed_pot(4000);
    cloud.centre[7].x = std::nanf("");
    write_splats(folder / "pot.splat", cloud);
    Scene s = read_scene(scene(""));
    const SplatObject object = load_splats(s, room).at(0);
    EXPECT_EQ(object.dropped, 1u);
    ASSERT_EQ(object.remarks.size(), 1u);
    EXPECT_NE(object.remarks[0].find("1 splats left out"), std::string::npos);
}

// Turned on its side, it is as wide as it was high.
TEST_F(SplatObjects, AnyAxisMayPointUp)
{
    Vec3<double> upright{};
    for (const char* up : {"y", "-y", "x", "z"}) {
        Scene s = read_scene(scene(", \"name\": \"pot\""), {std::string("objects.0.up=") + up});
        load_splats(s, room);
        const Vec3<double> size = s.objects[0].size;
        if (*up == 'y') upright = size;
        const Vec3<double> as = *up == 'x'   ? Vec3<double>{upright.y, upright.x, upright.z}
                                : *up == 'z' ? Vec3<double>{upright.x, upright.z, upright.y}
                                             : upright;
        EXPECT_NEAR(size.x, as.x, 0.02) << up;
        EXPECT_NEAR(size.y, as.y, 0.02) << up;
        EXPECT_NEAR(size.z, as.z, 0.02) << up;
    }
}

// About the vertical, `rotation` is the same as `turn`.
TEST_F(SplatObjects, AreRotatedAboutTheCentreThatTheSceneStates)
{
    const auto loaded = [&](const std::vector<std::string>& settings) {
        Scene s = read_scene(scene(""), settings);
        SplatCloud cloud = joined(load_splats(s, room));
        build(s, room);
        EXPECT_EQ(length(s.objects[0].centre + s.origin - Vec3<double>{0.3, 0.25, 0.3}), 0);
        return std::pair(s.objects[0], cloud);
    };
    const std::string half = "0.7071067811865476";
    const auto [plain, cloud] = loaded({});
    const auto [turned, with_turn] = loaded({"objects.0.turn=90"});
    const auto [about_y, with_rotation] =
        loaded({"objects.0.rotation=[" + half + ",0," + half + ",0]"});
    EXPECT_LT(length(turned.size - about_y.size), 1e-6);
    EXPECT_LT(length(turned.given->middle - about_y.given->middle), 1e-6);
    ASSERT_EQ(with_turn.count(), with_rotation.count());
    for (std::size_t i = 0; i < with_turn.count(); ++i)
        ASSERT_LT(length(with_turn.centre[i] - with_rotation.centre[i]), 1e-5f);
    const Object lying = loaded({"objects.0.rotation=[" + half + ",0,0," + half + "]"}).first;
    EXPECT_NEAR(lying.size.x, plain.size.y, 0.01);
    EXPECT_NEAR(lying.size.y, plain.size.x, 0.01);
    EXPECT_NEAR(lying.size.z, plain.size.z, 0.01);
    EXPECT_NEAR(shape_volume(lying) / shape_volume(plain), 1, 0.02);
}

TEST_F(SplatObjects, SeveralAreOneCloudInTheOrderOfTheirGaussians)
{
    Scene s = read_scene(scene(R"(, "per_cell": 2, "category": 1)",
                               R"(, {"shape": "sphere", "centre": [0.1, 0.1, 0.1], "diameter": 0.1},
                  {"shape": "splats", "file": "pot.splat", "size": 0.1, "up": "y", "category": 1,
                   "centre": [0.5, 0.3, 0.5]})"));
    const std::vector<SplatObject> objects = load_splats(s, room);
    build(s, room);
    const SplatCloud all = joined(objects);
    ASSERT_EQ(s.setup.gaussians.size(), all.count());
    EXPECT_EQ(all.sh.size(), all.count() * std::size_t(harmonics(all.degree)));
    for (std::size_t i = 0; i < all.count(); ++i) {
        const Gaussian<double>& g = s.setup.gaussians[i];
        ASSERT_LT(length(g.x - cast<double>(all.centre[i])), 1e-12);
        ASSERT_EQ(g.object, i < objects[0].cloud.count() ? 0 : 2);
    }
}

TEST_F(SplatObjects, WhatCannotBeIsSaidWithItsPlace)
{
    const auto loading = [&](const std::vector<std::string>& settings) {
        return reason<InputError>([&] {
            Scene s = read_scene(scene(""), settings);
            load_splats(s, room);
            build(s, room);
        });
    };
    EXPECT_NE(loading({"objects.0.file=nothing.ply"}).find("/objects/0"), std::string::npos);
    EXPECT_NE(loading({"objects.0.file=../pot.splat"}).find("inside"), std::string::npos);
    EXPECT_NE(loading({"objects.0.file=/pot.splat"}).find("inside"), std::string::npos);
    EXPECT_NE(loading({"objects.0.file="}).find("/objects/0/file"), std::string::npos);
    EXPECT_NE(loading({"objects.0.file=scene.json"}).find("/objects/0"), std::string::npos);
    EXPECT_NE(loading({"objects.0.size=0"}).find("/objects/0/size"), std::string::npos);
    EXPECT_NE(loading({"objects.0.size=0.9"}).find("between the walls"), std::string::npos);
    const std::string shared = reason<InputError>([&] {
        read_scene(
            scene("", R"(, {"shape": "sphere", "centre": [0.1, 0.1, 0.1], "diameter": 0.1})"));
    });
    EXPECT_NE(shared.find("category"), std::string::npos) << shared;
    Scene s = read_scene(scene(""));
    EXPECT_THROW(load_splats(s, 1000), MemoryError);
    EXPECT_THROW(build(s, room), std::logic_error) << "its splats are not loaded";
}

TEST(PotOfTheScenes, IsTheOneThatIsGenerated)
{
    const SplatCloud file = read_splats("scenes/pot.spz").cloud;
    const SplatCloud pot = placed(glazed_pot(), {0, 1, 0, 0}, 1, {0, 0, 0});  // y down
    ASSERT_EQ(file.count(), pot.count());
    EXPECT_EQ(file.degree, pot.degree);
    double farthest = 0;
    for (std::size_t i = 0; i < pot.count(); ++i)
        farthest = std::fmax(farthest, double(length(file.centre[i] - pot.centre[i])));
    EXPECT_LT(farthest, 5e-4);  // SPZ's steps
}

}  // namespace
}  // namespace knead
