// Files of splats: .splat by hand, what is broken ends in a message, the content says what a file
// is, and formats become each other.
#include "host/files/splat_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "host/base/errors.h"
#include "host/base/json_reader.h"
#include "host/base/outputs.h"
#include "host/files/file_kind.h"
#include "host/files/gzip.h"
#include "tests/files/splat_cases.h"
#include "tests/folder.h"

namespace knead {
namespace {

// A row as its bytes stand in the file.
std::string splat_row(std::vector<float> six, std::vector<std::uint8_t> eight)
{
    return bytes_of(six) + bytes_of(eight);
}

TEST(DotSplat, ARowByHandIsRead)
{
    const std::string bytes =
        splat_row({1, 2, -3, 0.1f, 0.2f, 0.3f}, {255, 0, 51, 204, 128, 255, 128, 128});
    const SplatFile file = parse_splat(bytes, "a.splat");
    ASSERT_EQ(file.cloud.count(), 1u);
    const double c0 = 1 / (2 * std::sqrt(std::acos(-1.0)));
    EXPECT_EQ(length(file.cloud.centre[0] - Vec3<float>{1, 2, -3}), 0);
    EXPECT_EQ(length(file.cloud.scale[0] - Vec3<float>{0.1f, 0.2f, 0.3f}), 0);
    EXPECT_NEAR(file.cloud.sh[0].x, 0.5 / c0, 1e-6);
    EXPECT_NEAR(file.cloud.sh[0].y, -0.5 / c0, 1e-6);
    EXPECT_NEAR(file.cloud.sh[0].z, -0.3 / c0, 1e-6);
    EXPECT_NEAR(file.cloud.opacity[0], 0.8, 1e-6);
    EXPECT_EQ(file.cloud.rotation[0].x, 1);
    EXPECT_EQ(splat_bytes(file.cloud), bytes);
}

TEST(DotSplat, NegativeAndZeroHalfAxesAreKeptAndNoRotationIsNot)
{
    const std::vector<std::uint8_t> sound{9, 9, 9, 9, 255, 128, 128, 128};
    const float nan = std::nanf("");
    const SplatFile file =
        parse_splat(splat_row({0, 0, 0, -1, -2, -3}, sound) + splat_row({0, 0, 0, 0, 2, 0}, sound) +
                        splat_row({0, 0, 0, 1, 1, 1}, {9, 9, 9, 9, 128, 128, 128, 128}) +
                        splat_row({0, nan, 0, 1, 1, 1}, sound),
                    "b.splat");
    ASSERT_EQ(file.cloud.count(), 2u);
    EXPECT_EQ(length(file.cloud.scale[0] - Vec3<float>{1, 2, 3}), 0);
    EXPECT_EQ(length(file.cloud.scale[1] - Vec3<float>{0, 2, 0}), 0);
    EXPECT_EQ(file.repairs.mirrored, 1u);
    EXPECT_EQ(file.repairs.no_rotation, 1u);
    EXPECT_EQ(file.repairs.not_finite, 1u);
    EXPECT_THROW(parse_splat("", "c.splat"), InputError);
    for (std::size_t size = 1; size < 70; ++size)
        if (size % 32) {
            EXPECT_THROW(parse_splat(std::string(size, '\1'), "c.splat"), InputError);
        }
}

TEST(DotSplat, WhatIsWrittenIsReadToAByte)
{
    SplatCloud cloud = drawn(500, 3, 2);
    const SplatCloud back = parse_splat(splat_bytes(cloud), "d.splat").cloud;
    EXPECT_EQ(back.degree, 0);
    const Apart most = apart(cloud, back);
    EXPECT_EQ(most.centre, 0);
    EXPECT_EQ(most.scale, 0);
    EXPECT_LE(most.opacity, 0.5 / 255 + 1e-6);
    EXPECT_LE(most.dc, 0.5 / 255 / sh_constant + 1e-6);
    // Each part is off by 1/256, or 1/128 where 1 is cut to 127/128: |dq|^2 / 2 at most.
    EXPECT_LE(most.rotation, (3 / (256.0 * 256) + 1 / (128.0 * 128)) / 2);
}

// Every byte of small files changed in several ways, and every length: a cloud or an InputError.
TEST(SplatFiles, NoByteOfAFileBreaksAReader)
{
    const SplatCloud cloud = drawn(2, 1, 7);
    std::string text = header("ascii", 1, plain);
    for (double v : one_row) text += std::to_string(v) + " ";
    const std::string open = SpzByHand{}.bytes();
    long refused = 0, read = 0;
    const auto tried = [&](const std::string& bytes, const std::string& path) {
        try {
            const SplatFile file = parse_splats(bytes, path);
            const SplatCloud& c = file.cloud;
            ASSERT_GT(c.count(), 0u);
            ASSERT_EQ(c.sh.size(), c.count() * std::size_t(harmonics(c.degree)));
            for (std::size_t i = 0; i < c.count(); ++i) {
                ASSERT_TRUE(std::isfinite(length(cast<double>(c.centre[i]))));
                ASSERT_TRUE(std::isfinite(length(cast<double>(c.scale[i]))));
                ASSERT_NEAR(turn_between(c.rotation[i], c.rotation[i]), 0, 1e-6);
                ASSERT_TRUE(c.opacity[i] >= 0 && c.opacity[i] <= 1);
            }
            ++read;
        } catch (const InputError&) {
            ++refused;
        }
    };
    for (const auto& [whole, path] :
         std::vector<std::pair<std::string, std::string>>{{splat_ply_bytes(cloud), "m.ply"},
                                                          {text, "t.ply"},
                                                          {splat_bytes(cloud), "m.splat"},
                                                          {gzipped(open), "m.spz"},
                                                          {open, "open.spz"}}) {
        for (std::size_t cut = 0; cut < whole.size(); ++cut) tried(whole.substr(0, cut), path);
        for (std::size_t at = 0; at < whole.size(); ++at)
            for (int flip : {1, 2, 4, 8, 16, 32, 64, 128, 255}) {
                std::string bytes = whole;
                bytes[at] = char(bytes[at] ^ flip);
                tried(bytes, path);
            }
    }
    EXPECT_GT(refused, 1000);
    EXPECT_GT(read, 1000);
}

class SplatPaths : public InFolder {};

TEST_F(SplatPaths, TheContentSaysWhatAFileIs)
{
    const SplatCloud cloud = drawn(3, 2, 8);
    for (const char* name : {"a.ply", "a.splat", "a.spz"}) {
        write_splats(path(name), cloud);
        EXPECT_EQ(file_kind(path(name)), FileKind::splats) << name;
        EXPECT_EQ(read_splats(path(name)).format, std::string(name).substr(2));
    }
    // Under another name, as far as the content tells.
    write_whole(path("b.bin"), read_text(path("a.spz"), 1 << 20));
    write_whole(path("c.splat"), read_text(path("a.ply"), 1 << 20));
    EXPECT_EQ(file_kind(path("b.bin")), FileKind::splats);
    EXPECT_EQ(read_splats(path("b.bin")).format, "spz");
    EXPECT_EQ(read_splats(path("c.splat")).format, "ply");
    const std::string points = header("ascii", 1, {"x", "y", "z"}) + "1 2 3\n";
    write_whole(path("points.ply"), points);
    EXPECT_EQ(file_kind(path("points.ply")), FileKind::particles);
    write_whole(path("gone.spz"), "nothing");
    EXPECT_THROW(read_splats(path("gone.spz")), InputError);
    EXPECT_THROW(write_splats(path("a.obj"), cloud), InputError);
    EXPECT_THROW(write_splats(path("none/a.ply"), cloud), OutputError);
    EXPECT_THROW(read_splats(path("absent.ply")), InputError);
    EXPECT_THROW(read_splats(folder.string()), InputError);
}

// What a run writes into its files lies within the steps of the coarser format.
TEST_F(SplatPaths, FormatsBecomeEachOther)
{
    const SplatCloud cloud = drawn(200, 3, 9);
    write_splats(path("a.ply"), cloud);
    write_splats(path("a.spz"), read_splats(path("a.ply")).cloud);
    write_splats(path("b.ply"), read_splats(path("a.spz")).cloud);
    const Apart most = apart(cloud, read_splats(path("b.ply")).cloud);
    EXPECT_LE(most.centre, 0x1p-16);
    EXPECT_LE(most.rest, 0.5 / 128 + 1e-6);
    EXPECT_LE(most.rotation, 4e-6);
}

}  // namespace
}  // namespace knead
