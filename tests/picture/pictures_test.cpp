// Pictures that cannot be made: they are missing, and the run is not.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/cli/verbs.h"
#include "host/picture/frame_writer.h"
#include "host/run/report.h"
#include "host/scene/seed.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {

class Pictures : public InFolder {
  protected:
    void SetUp() override
    {
        write_whole(path("scene.json"), R"({
            "schema": "knead.scene/1", "domain": {"edge": 0.32, "cells": 16},
            "objects": [{"centre": [0.16, 0.16, 0.16], "diameter": 0.1,
                         "material": {"preset": "clay", "young": 1e4}}]})");
    }
    Scene scene() const
    {
        Scene s = read_scene(path("scene.json"), {});
        build(s, std::size_t(1) << 32);
        return s;
    }
};

std::string drawn_by()
{
    try {
        return Painter::open()->name();
    } catch (const std::runtime_error&) {
        return "";
    }
}

TEST_F(Pictures, OneThatCannotBeMadeIsCountedAndSaidOnceAndTheRunGoesOn)
{
    const Scene small = scene();
    const std::unique_ptr<Simulator> solver = cpu_solver(small.setup);
    BatchRunOptions options;
    options.frames = 5, options.mesh_every = 1;
    int polls = 0;
    RunObserver watch;
    watch.picture = [&](const FrameResult& f, const std::vector<Mesh>&) {
        ++polls;
        if (f.number % 2 == 0) throw PictureError("no room");
    };
    testing::internal::CaptureStderr();
    const RunRecord record = run_frames(small, *solver, nullptr, options, watch);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "knead: no picture of frame 2: no room\n");
    EXPECT_EQ(record.end, End::complete);
    EXPECT_EQ(record.rows.size(), 5u);
    EXPECT_EQ(polls, 5);
    EXPECT_EQ(record.pictures_missing, 2);
    RunInfo facts;
    facts.left_out = {"before"};
    const Json all = report(small, record, facts)["knead"]["left_out"];
    EXPECT_EQ(all,
              Json({"before", "pictures: 2 could not be made; the first, of frame 2: no room"}));
}

TEST_F(Pictures, WiderThanTheDeviceDrawsAreRefusedBeforeTheFirst)
{
    const std::string device = drawn_by();
    if (device.empty()) GTEST_SKIP() << "no OpenGL";
    Scene wide = scene();
    wide.picture_width = Painter::open()->largest_side() + 1;
    const std::string said =
        reason<std::runtime_error>([&] { FrameWriter(wide, path("pictures"), "", 30); });
    EXPECT_NE(said.find("a side can be drawn on " + device), std::string::npos) << said;
    EXPECT_EQ(files(), 1);
}

TEST_F(Pictures, ARunWithPicturesOf5000PixelsIsWhole)
{
    if (drawn_by().empty()) GTEST_SKIP() << "no OpenGL";
    RunOptions o;
    o.scene = path("scene.json"), o.out = path("out"), o.device = "cpu", o.frames = 1;
    o.quiet = true, o.pictures = 1;
    o.settings = {"pictures.width=5000", "pictures.height=16"};
    EXPECT_EQ(run_verb(o), exit_ok);
    const Json all = read_json(path("out/report.json"))["knead"];
    EXPECT_EQ(all["end"], "complete");
    EXPECT_TRUE(std::filesystem::exists(path("out/pictures/frame_00001.png")))
        << all["left_out"].dump();
}

// A camera on its own target sees nothing that could be drawn.
TEST_F(Pictures, ACameraThatSeesNothingCostsItsPictures)
{
    if (drawn_by().empty()) GTEST_SKIP() << "no OpenGL";
    Scene blind = scene();
    blind.eye = blind.target;
    FrameWriter writer(blind, path("pictures"), "", 30);
    EXPECT_NE(reason<PictureError>([&] { writer.add(FrameResult{}, {}); }), "");
    EXPECT_EQ(writer.count(), 0);
}

TEST_F(Pictures, OneThatIsGivenUpIsNotThere)
{
    if (drawn_by().empty()) GTEST_SKIP() << "no OpenGL";
    Scene small = scene();
    small.picture_width = 240, small.picture_height = 180;
    FrameWriter writer(small, path("pictures"), "", 30);
    // Given up at each moment at which it can be, until it never is: drawing, then row by row.
    int given_up = 0;
    for (int last = 0;; last += 20, ++given_up) {
        int polls = 0;
        writer.give_up_when([&] { return polls++ == last; });
        if (reason<PictureError>([&] { writer.add(FrameResult{}, {}); }).empty()) break;
        ASSERT_TRUE(std::filesystem::is_empty(path("pictures"))) << last;
        ASSERT_LT(last, 10000);
    }
    EXPECT_GE(given_up, small.picture_height / 20) << "not asked before every row";
    EXPECT_EQ(writer.count(), 1);
    EXPECT_TRUE(std::filesystem::exists(path("pictures/frame_00000.png")));
}

}  // namespace
}  // namespace knead
