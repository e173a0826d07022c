// What ffmpeg is given, and what becomes of the video when it does not do its part: with a program
// of its name that does what the test asks for, so wherever there is none.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/cli/verbs.h"
#include "host/files/video.h"
#include "render/painter.h"
#include "tests/files/fake_ffmpeg.h"
#include "tests/folder.h"
#include "tests/reason.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

class VideoPipe : public InFolder {
  protected:
    // What is said where a video of so many pictures is made and ended; "": it was made.
    std::string made(const std::string& does, int pictures = 3)
    {
        const FakeFfmpeg fake(path("bin"), does);
        return reason<OutputError>([&] {
            const auto video = Video::open(path("clip.mp4"), 32, 16, 30);
            for (int k = 0; k < pictures; ++k) video->add(picture(32, 16, k));
            video->close();
        });
    }
    static Image picture(int width, int height, int shade)
    {
        Image image{width, height, {}};
        for (int i = 0; i < 3 * width * height; ++i)
            image.rgb.push_back(std::uint8_t(7 * i + 50 * shade));
        return image;
    }
    static std::string bytes_of(const Image& image) { return {image.rgb.begin(), image.rgb.end()}; }
    std::string read(const std::string& name) const { return read_text(path(name), 1 << 24); }
};

bool says(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

TEST_F(VideoPipe, EveryPictureArrivesInItsOrder)
{
    const FakeFfmpeg fake(path("bin"));
    ASSERT_TRUE(Video::available());
    std::string sent;
    {
        const auto video = Video::open(path("clip.mp4"), 61, 37, 12.5);
        for (int k = 0; k < 5; ++k) {
            const Image image = picture(61, 37, k);
            video->add(image);
            sent += bytes_of(image);
        }
        EXPECT_FALSE(fs::exists(path("clip.mp4"))) << "there before it is whole";
        video->close();
        EXPECT_TRUE(read("clip.mp4") == sent);
        EXPECT_THROW(video->add(picture(61, 37, 0)), OutputError) << "closed";
    }
    const std::string words = read("bin/words");
    EXPECT_PRED2(says, words, "-video_size\n61x37\n-framerate\n12.5\n-i\npipe:0\n");
    EXPECT_PRED2(says, words, "\npad=ceil(iw/2)*2:ceil(ih/2)*2\n");
    EXPECT_PRED2(says, words, "\nfile:" + path("clip.partial-"));
    EXPECT_EQ(files(), 2);
}

TEST_F(VideoPipe, OneThatIsNotClosedKeepsItsPictures)
{
    const FakeFfmpeg fake(path("bin"));
    Video::open(path("clip.mp4"), 32, 16, 30)->add(picture(32, 16, 1));
    EXPECT_TRUE(read("clip.mp4") == bytes_of(picture(32, 16, 1)));
}

TEST_F(VideoPipe, WhatFfmpegSaysIsTheReasonAndTheOldFileStays)
{
    write_whole(path("clip.mp4"), "old");
    const std::string at = path("clip.mp4") + ": the video cannot be written: ";
    EXPECT_EQ(made("cat >/dev/null; echo 'no such codec' >&2; echo >&2; exit 1"),
              at + "ffmpeg says: no such codec");
    EXPECT_EQ(made("cat >/dev/null; exit 7"), at + "ffmpeg ended with status 7");
    EXPECT_EQ(made("cat >/dev/null; kill -9 $$"), at + "ffmpeg ended by signal 9");
    // It is gone before the pictures are, which is no end of ours by SIGPIPE.
    EXPECT_EQ(made("echo 'full' >\"${to#file:}\"; echo 'disk full' >&2; exit 1", 2000),
              at + "ffmpeg says: disk full");
    const std::string talk = made("cat >/dev/null; seq 2000 >&2; exit 1");
    EXPECT_PRED2(says, talk, "ffmpeg says: ... ");
    EXPECT_TRUE(talk.ends_with("1999\n2000"));
    EXPECT_LT(talk.size(), 2200u);
    EXPECT_EQ(read("clip.mp4"), "old");
    EXPECT_EQ(files(), 2);
    EXPECT_EQ(made(FakeFfmpeg::keep), "");
    EXPECT_EQ(read("clip.mp4").size(), 3u * 3 * 32 * 16);
}

TEST_F(VideoPipe, OneThatDoesNotStartIsSaid)
{
    const FakeFfmpeg fake(path("bin"));
    fs::remove(path("bin/ffmpeg"));
    fs::create_directory(path("bin/ffmpeg"));  // may be entered, as a program may be run
    const char* const before = std::getenv("PATH");
    const std::string all = before;
    setenv("PATH", path("bin").c_str(), 1);
    const std::string said =
        reason<OutputError>([&] { Video::open(path("clip.mp4"), 32, 16, 30); });
    setenv("PATH", path("nowhere").c_str(), 1);
    const std::string none =
        reason<OutputError>([&] { Video::open(path("clip.mp4"), 32, 16, 30); });
    setenv("PATH", all.c_str(), 1);
    EXPECT_PRED2(says, said, "ffmpeg does not start: ");
    EXPECT_PRED2(says, none, "ffmpeg is not on the PATH");
    EXPECT_EQ(files(), 1);
}

TEST_F(VideoPipe, ARunsVideoHasItsPicturesAndOneThatFailsCostsTheVideoAlone)
{
    try {
        Painter::open();
    } catch (const std::runtime_error& e) {
        GTEST_SKIP() << e.what();
    }
    write_whole(path("scene.json"), R"({
        "schema": "knead.scene/1", "domain": {"edge": 0.32, "cells": 16}, "frame_rate": 60,
        "objects": [{"centre": [0.16, 0.16, 0.16], "diameter": 0.1,
                     "material": {"preset": "clay", "young": 1e4}}],
        "pictures": {"width": 40, "height": 30}})");
    RunOptions o;
    o.scene = path("scene.json"), o.out = path("out"), o.device = "cpu", o.frames = 6;
    o.quiet = true, o.video = true;
    {
        const FakeFfmpeg fake(path("bin"));
        EXPECT_EQ(run_verb(o), exit_ok);
    }
    // Every second frame, for 30 pictures a second.
    EXPECT_EQ(read("out/video.mp4").size(), 3u * 3 * 40 * 30);
    EXPECT_PRED2(says, read("bin/words"), "-framerate\n30\n");
    {
        const FakeFfmpeg fake(path("bin"), "cat >/dev/null; echo 'no room' >&2; exit 1");
        o.overwrite = true;
        testing::internal::CaptureStderr();
        EXPECT_EQ(run_verb(o), exit_output);
        EXPECT_PRED2(says, testing::internal::GetCapturedStderr(), "ffmpeg says: no room");
    }
    EXPECT_FALSE(fs::exists(path("out/video.mp4")));
    EXPECT_EQ(read_json(path("out/report.json"))["knead"]["end"], "complete");
    EXPECT_TRUE(fs::exists(path("out/mesh.glb")));
}

}  // namespace
}  // namespace knead
