// PNG files and videos: what is read back is what was written, and what fails is named.
#include <gtest/gtest.h>
#include <png.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/files/image.h"
#include "host/files/video.h"
#include "render/painter.h"
#include "tests/asks.h"
#include "tests/folder.h"
#include "tests/reason.h"
#include "tests/small_disk.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

class PictureFile : public InFolder {};

Image gradient(int width, int height, int shift = 0)
{
    Image image{width, height, {}};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            for (const int c : {x * 7 + shift, y * 5, x ^ y}) image.rgb.push_back(std::uint8_t(c));
        }
    }
    return image;
}

Image plain(int width, int height, std::uint8_t grey)
{
    return {
        width, height,
        std::vector<std::uint8_t>(std::size_t(3) * std::size_t(width) * std::size_t(height), grey)};
}

bool says(const std::string& text, const std::string& part)
{
    return text.find(part) != std::string::npos;
}

TEST_F(PictureFile, APngReadsBackAsTheSamePixels)
{
    const Image image = gradient(61, 37);
    write_png(path("a.png"), plain(3, 3, 9));
    write_png(path("a.png"), image);  // replaces
    png_image head{};
    head.version = PNG_IMAGE_VERSION;
    ASSERT_TRUE(png_image_begin_read_from_file(&head, path("a.png").c_str())) << head.message;
    EXPECT_EQ(head.width, 61u);
    EXPECT_EQ(head.height, 37u);
    head.format = PNG_FORMAT_RGB;
    std::vector<std::uint8_t> back(image.rgb.size());
    ASSERT_TRUE(png_image_finish_read(&head, nullptr, back.data(), 0, nullptr)) << head.message;
    EXPECT_EQ(back, image.rgb);
    EXPECT_EQ(files(), 1);
}

TEST_F(PictureFile, APngIsReadWholeOrRefusedWithPathAndReason)
{
    const Image image = gradient(61, 37);
    write_png(path("a.png"), image);
    const Image back = read_png(path("a.png"));
    EXPECT_EQ(back.width, 61);
    EXPECT_EQ(back.height, 37);
    EXPECT_EQ(back.rgb, image.rgb);
    const std::string whole = read_text(path("a.png"), 1 << 20);
    const auto refused = [&](const std::string& bytes) {
        write_whole(path("b.png"), bytes);
        const std::string why = reason<InputError>([&] { read_png(path("b.png")); });
        EXPECT_PRED2(says, why, path("b.png"));
        return !why.empty();
    };
    // The last chunk of 12 bytes holds nothing, and the one before a checksum.
    for (std::size_t cut = 0; cut < whole.size() - 16; cut += 7)
        EXPECT_TRUE(refused(whole.substr(0, cut))) << cut << " bytes of " << whole.size();
    for (std::size_t at : {std::size_t(0), std::size_t(17), whole.size() / 2}) {
        std::string bad = whole;
        bad[at] = char(bad[at] ^ 0x55);
        EXPECT_TRUE(refused(bad)) << at;
    }
    // A head that promises more than anyone draws, with its checksum.
    png_image head{};
    head.version = PNG_IMAGE_VERSION, head.format = PNG_FORMAT_GRAY;
    head.width = 70000, head.height = 1000;
    const std::vector<std::uint8_t> grey(70000 * 1000);
    ASSERT_TRUE(png_image_write_to_file(&head, path("b.png").c_str(), 0, grey.data(), 0, nullptr));
    EXPECT_PRED2(says, reason<InputError>([&] { read_png(path("b.png")); }),
                 "70000 x 1000 pixels; expected at most 67108864 in all");
    EXPECT_NE(reason<InputError>([&] { read_png(path("none.png")); }), "");
}

TEST_F(PictureFile, APngThatCannotBeWrittenNamesPathAndReasonAndLeavesNothing)
{
    const Image image = gradient(4, 4);
    const auto error = [&](const std::string& path) {
        return reason<std::runtime_error>([&] { write_png(path, image); });
    };
    EXPECT_PRED2(says, error(path("no/a.png")), path("no/a.png"));
    EXPECT_PRED2(says, error(path("no/a.png")), "No such file or directory");
    EXPECT_PRED2(says, error("/proc/a.png"), "/proc/a.png");
    EXPECT_PRED2(says, error(""), "empty");
    fs::create_directory(path("folder.png"));
    EXPECT_PRED2(says, error(path("folder.png")), "directory");
    EXPECT_EQ(files(), 1);
    fs::create_directory(path("locked"));
    fs::permissions(path("locked"), fs::perms::owner_read | fs::perms::owner_exec);
    if (std::ofstream(path("locked/probe")).good()) {
        fs::remove(path("locked/probe"));  // this user may write anywhere
    } else {
        EXPECT_PRED2(says, error(path("locked/a.png")), "Permission denied");
    }
    fs::permissions(path("locked"), fs::perms::owner_all);
}

// Rows that nothing compresses, as wide as pictures get.
Image noise(int width, int height)
{
    Image image = plain(width, height, 0);
    std::uint32_t state = 1;
    for (std::uint8_t& c : image.rgb)
        state = state * 1664525 + 1013904223, c = std::uint8_t(state >> 24);
    return image;
}

TEST_F(PictureFile, AHugePngIsGivenUpSoonAndLeavesTheOldOne)
{
    const Image image = noise(8192, 1024);
    write_png(path("a.png"), plain(3, 3, 9));
    Asks asks;
    EXPECT_FALSE(write_png(path("a.png"), image, asks.until(501)));
    EXPECT_LT(asks.longest_wait(), 0.1);
    EXPECT_EQ(asks.count, 501);
    EXPECT_EQ(read_png(path("a.png")).width, 3);
    EXPECT_EQ(files(), 1);

    EXPECT_FALSE(write_png(path("b.png"), gradient(8, 4), [] { return true; }));
    EXPECT_EQ(files(), 1);
    EXPECT_TRUE(write_png(path("b.png"), gradient(8, 4), [] { return false; }));
    EXPECT_EQ(read_png(path("b.png")).rgb, gradient(8, 4).rgb);
}

TEST_F(PictureFile, ADiskThatRunsFullLeavesTheOldPicture)
{
    const Image old = gradient(4, 4);
    write_png(path("a.png"), old);
    const std::string before = read_text(path("a.png"), 1 << 20);
    std::string error;
    {
        const SmallDisk full(256);
        error = reason<OutputError>([&] { write_png(path("a.png"), gradient(200, 200)); });
    }
    EXPECT_EQ(error, path("a.png") + ": cannot be written: File too large");
    EXPECT_TRUE(read_text(path("a.png"), 1 << 20) == before);
    EXPECT_EQ(files(), 1);
}

TEST_F(PictureFile, AnImageThatContradictsItsSizeIsRefused)
{
    Image image = gradient(4, 4);
    image.rgb.pop_back();
    const auto error = [&] {
        return reason<std::runtime_error>([&] { write_png(path("a.png"), image); });
    };
    EXPECT_PRED2(says, error(), "4 x 4 pixels need 48 bytes, but there are 47");
    image.width = -4;
    EXPECT_PRED2(says, error(), "-4 x 4");
    image = plain(1000001, 1, 0);  // wider than libpng writes any
    EXPECT_PRED2(says, error(), path("a.png") + ": the picture cannot be written: Invalid IHDR");
    EXPECT_EQ(files(), 0);
}

class VideoFile : public PictureFile {
  protected:
    void SetUp() override
    {
        if (!Video::available()) GTEST_SKIP() << "ffmpeg is not on the PATH";
        PictureFile::SetUp();
    }
};

TEST_F(VideoFile, HoldsEveryFrameUnderAnyName)
{
    // Odd sides, and a name that a shell or an option parser would misread.
    const std::string strange = path("-it's $(a) \"clip\": 1.mp4");
    const auto video = Video::open(strange, 61, 37, 30);
    for (int i = 0; i < 12; ++i) video->add(plain(61, 37, std::uint8_t(20 * i)));
    video->close();
    video->close();  // once more is no harm
    ASSERT_TRUE(fs::exists(strange));
    EXPECT_EQ(files(), 1);
    fs::rename(strange, path("clip.mp4"));
    const std::string command =
        "ffmpeg -loglevel error -i '" + path("clip.mp4") + "' -f rawvideo -pix_fmt gray pipe:1";
    std::FILE* pipe = ::popen(command.c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    std::vector<std::uint8_t> grey(20 * 62 * 38);
    grey.resize(std::fread(grey.data(), 1, grey.size(), pipe));
    EXPECT_EQ(::pclose(pipe), 0);
    ASSERT_EQ(grey.size(), 12u * 62 * 38);
    for (int i = 0; i < 12; ++i)
        EXPECT_NEAR(grey[std::size_t(i) * 62 * 38 + 62 * 10 + 20], 20 * i, 12);
}

TEST_F(VideoFile, KeepsItsFramesWhenItIsNotClosed)
{
    {
        const auto video = Video::open(path("clip.mp4"), 32, 32, 30);
        for (int i = 0; i < 5; ++i) video->add(gradient(32, 32, i));
    }
    EXPECT_TRUE(fs::exists(path("clip.mp4")));
    EXPECT_EQ(files(), 1);
}

TEST_F(VideoFile, WhatFfmpegRefusesIsNamedAndEndsNobody)
{
    // ffmpeg gives up on the ending; frames sent after it has gone must not raise SIGPIPE.
    const std::string error = reason<std::runtime_error>([&] {
        const auto video = Video::open(path("clip.no-such-kind"), 320, 240, 30);
        for (int i = 0; i < 200; ++i) video->add(gradient(320, 240, i));
        video->close();
    });
    EXPECT_PRED2(says, error, "clip.no-such-kind");
    EXPECT_PRED2(says, error, "ffmpeg says");
    EXPECT_EQ(files(), 0);
}

// ffmpeg inherits the limit; of so small a video only the end does not fit.
TEST_F(VideoFile, ADiskThatRunsFullLeavesTheOldFile)
{
    write_whole(path("clip.mp4"), "old");
    const std::string error = reason<OutputError>([&] {
        const SmallDisk full(2048);
        const auto video = Video::open(path("clip.mp4"), 320, 240, 30);
        for (int i = 0; i < 30; ++i) video->add(gradient(320, 240, 9 * i));
        video->close();
    });
    EXPECT_PRED2(says, error, path("clip.mp4"));
    EXPECT_PRED2(says, error, "File too large");
    EXPECT_EQ(read_text(path("clip.mp4"), 100), "old");
    EXPECT_EQ(files(), 1);
}

TEST_F(VideoFile, ABadPathSizeOrRateIsNamedBeforeFfmpegStarts)
{
    const auto error = [&](const std::string& path, int width, double rate) {
        return reason<std::exception>([&] { Video::open(path, width, 32, rate); });
    };
    EXPECT_PRED2(says, error(path("no/clip.mp4"), 32, 30), "No such file or directory");
    EXPECT_PRED2(says, error("/proc/clip.mp4", 32, 30), "/proc/clip.mp4");
    EXPECT_PRED2(says, error("", 32, 30), "empty");
    EXPECT_PRED2(says, error(path("clip.mp4"), 0, 30), "0 x 32");
    EXPECT_PRED2(says, error(path("clip.mp4"), 32, 0), "frames per second");
    EXPECT_PRED2(says, error(path("clip.mp4"), 32, std::nan("")), "frames per second");
    EXPECT_EQ(files(), 0);
}

TEST_F(VideoFile, AFrameOfAnotherSizeIsRefused)
{
    const auto video = Video::open(path("clip.mp4"), 32, 32, 30);
    video->add(gradient(32, 32));
    const std::string error = reason<std::invalid_argument>([&] { video->add(gradient(16, 32)); });
    EXPECT_PRED2(says, error, "16 x 32");
    video->close();
    EXPECT_THROW(video->add(gradient(32, 32)), std::runtime_error);
}

}  // namespace
}  // namespace knead
