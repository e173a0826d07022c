// Splats as PLY: each dialect by hand, what cannot be drawn is counted, what is written is read.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "host/base/errors.h"
#include "tests/files/splat_cases.h"
#include "tests/reason.h"

namespace knead {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

void expect_one_row(const SplatFile& file, double tolerance = 1e-6)
{
    const SplatCloud& c = file.cloud;
    ASSERT_EQ(c.count(), 1u);
    EXPECT_EQ(c.degree, 0);
    EXPECT_EQ(file.repairs.dropped() + file.repairs.mirrored, 0u);
    EXPECT_LT(length(c.centre[0] - Vec3<float>{1, 2, -3}), tolerance);
    EXPECT_LT(length(c.sh[0] - Vec3<float>{0.5f, 0.25f, -1}), tolerance);
    EXPECT_NEAR(c.opacity[0], 0.5, tolerance);
    const double e = 2.718281828459045;
    EXPECT_LT(length(cast<double>(c.scale[0]) - Vec3<double>{1, e, 1 / e}), 3 * tolerance);
    EXPECT_NEAR(c.rotation[0].w, std::sqrt(0.5), tolerance);
    EXPECT_NEAR(c.rotation[0].x, std::sqrt(0.5), tolerance);
    EXPECT_EQ(c.rotation[0].y, 0);
    EXPECT_EQ(c.rotation[0].z, 0);
}

TEST(SplatPly, EveryFormatAndOrderOfBytesIsTheSameSplat)
{
    expect_one_row(parse_splat_ply(little(one_row), "little.ply"));
    const std::vector<float> floats(one_row.begin(), one_row.end());
    expect_one_row(
        parse_splat_ply(header("binary_big_endian", 1, plain) + swapped(floats), "big.ply"));
    const std::string doubles = header("binary_little_endian", 1, plain, "double");
    expect_one_row(parse_splat_ply(doubles + bytes_of(one_row), "double.ply"));
    std::string text = header("ascii", 1, plain, "float32", "comment by hand\nobj_info any\n");
    for (double v : one_row) text += std::to_string(v) + " ";
    expect_one_row(parse_splat_ply(text + "\n", "text.ply"));
}

// As some exporters write them: half-precision floats by name, or their bits as whole numbers.
TEST(SplatPly, HalvesAreReadByTheirNameAndAsWholeNumbers)
{
    // 1 2 -3 0.5 0.25 -1 0 0 1 -1 2 2 0 0 in IEEE 754 binary16.
    const std::vector<std::uint16_t> halves{0x3c00, 0x4000, 0xc200, 0x3800, 0x3400, 0xbc00, 0,
                                            0,      0x3c00, 0xbc00, 0x4000, 0x4000, 0,      0};
    for (const char* type : {"half", "float16", "ushort", "uint16"}) {
        const std::string head = header("binary_little_endian", 1, plain, type);
        expect_one_row(parse_splat_ply(head + bytes_of(halves), type));
    }
    const std::string head = header("binary_big_endian", 1, plain, "half");
    expect_one_row(parse_splat_ply(head + swapped(halves), "half.ply"));
}

TEST(SplatPly, HalvesHaveTheValuesOfTheStandard)
{
    EXPECT_EQ(half_number(0x0001), 0x1p-24);
    EXPECT_EQ(half_number(0x03ff), 1023 * 0x1p-24);
    EXPECT_EQ(half_number(0x0400), 0x1p-14);
    EXPECT_EQ(half_number(0x7bff), 65504);
    EXPECT_EQ(half_number(0x3555), 1365 * 0x1p-12);
    EXPECT_EQ(half_number(0xfc00), -infinity);
    EXPECT_TRUE(std::isnan(half_number(0x7e00)));
    EXPECT_TRUE(std::signbit(half_number(0x8000)));
}

TEST(SplatPly, PropertiesMayStandInAnyOrderAmongOthers)
{
    Names names = plain;
    std::vector<double> row = one_row;
    std::reverse(names.begin(), names.end());
    std::reverse(row.begin(), row.end());
    for (const char* normal : {"nx", "ny", "nz"}) {
        names.insert(names.begin() + 5, normal);
        row.insert(row.begin() + 5, 7);
    }
    expect_one_row(parse_splat_ply(little(row, names), "reversed.ply"));
    // Another element before and one with a list behind.
    std::string text =
        "ply\nformat binary_little_endian 1.0\nelement camera 2\nproperty uchar id\n"
        "element vertex 1\n" +
        properties(plain) + "element path 1\nproperty list uchar int at\nend_header\n";
    text += std::string("\1\2") + bytes_of(std::vector<float>(one_row.begin(), one_row.end()));
    text += std::string("\1") + bytes_of(std::vector<int>{9});
    expect_one_row(parse_splat_ply(text, "among.ply"));
}

TEST(SplatPly, HarmonicsStandChannelByChannel)
{
    for (int degree = 0; degree <= 4; ++degree) {
        Names names = plain;
        std::vector<double> row = one_row;
        const int each = harmonics(degree) - 1;
        for (int k = 0; k < 3 * each; ++k) {
            names.push_back("f_rest_" + std::to_string(k));
            row.push_back(k);
        }
        const SplatFile file = parse_splat_ply(little(row, names), "sh.ply");
        const int kept = std::min(degree, 3);
        ASSERT_EQ(file.cloud.degree, kept);
        EXPECT_EQ(file.repairs.degree_left_out, degree == 4 ? 4 : 0);
        ASSERT_EQ(file.cloud.sh.size(), std::size_t(harmonics(kept)));
        EXPECT_EQ(file.cloud.sh[0].y, 0.25f);
        for (int k = 1; k < harmonics(kept); ++k) {
            const Vec3<float> c = file.cloud.sh[std::size_t(k)];
            EXPECT_EQ(c.x, float(k - 1));
            EXPECT_EQ(c.y, float(each + k - 1));
            EXPECT_EQ(c.z, float(2 * each + k - 1));
        }
    }
}

TEST(SplatPly, FlatSplatsLackAHalfAxisAndColourlessOnesAreGrey)
{
    Names names = plain;
    std::vector<double> row = one_row;
    names.erase(names.begin() + 9);
    row.erase(row.begin() + 9);
    EXPECT_EQ(parse_splat_ply(little(row, names), "flat.ply").cloud.scale[0].z, 0);
    names.erase(names.begin() + 3, names.begin() + 6);
    row.erase(row.begin() + 3, row.begin() + 6);
    EXPECT_EQ(length(parse_splat_ply(little(row, names), "grey.ply").cloud.sh[0]), 0);
}

TEST(SplatPly, CommentsTellTheScreenFilter)
{
    const auto antialiased = [](const std::string& comment) {
        const std::string head = header("binary_little_endian", 1, plain, "float", comment);
        const std::vector<float> floats(one_row.begin(), one_row.end());
        return parse_splat_ply(head + bytes_of(floats), "c.ply").cloud.antialiased;
    };
    EXPECT_TRUE(antialiased("comment SplatRenderMode: mip\n"));
    EXPECT_TRUE(antialiased("comment antialiased 1\n"));
    EXPECT_FALSE(antialiased("comment antialiased 0\n"));
    EXPECT_FALSE(antialiased("comment SplatRenderMode: default\n"));
}

// Which infinities are sound: an opacity of 1 or 0, a half axis of 0.
TEST(SplatPly, WhatCannotBeDrawnIsDroppedAndCounted)
{
    const double nan = std::nan("");
    struct Case {
        std::size_t column;
        double value;
        bool kept;
    };
    const std::vector<Case> cases{
        {0, nan, false},       {1, infinity, false},  {2, 1e300, false},     {3, nan, false},
        {4, -infinity, false}, {6, nan, false},       {6, infinity, true},   {6, -infinity, true},
        {7, nan, false},       {7, infinity, false},  {7, -infinity, true},  {8, 1000, false},
        {10, nan, false},      {11, infinity, false}, {13, -infinity, false}};
    std::vector<double> rows = one_row;
    std::size_t kept = 1;
    for (const Case& c : cases) {
        std::vector<double> row = one_row;
        row[c.column] = c.value;
        rows.insert(rows.end(), row.begin(), row.end());
        kept += c.kept;
    }
    std::vector<double> still = one_row;
    still[10] = still[11] = 0;
    rows.insert(rows.end(), still.begin(), still.end());
    const std::string head = header("binary_little_endian", cases.size() + 2, plain, "double");
    const SplatFile file = parse_splat_ply(head + bytes_of(rows), "odd.ply");
    EXPECT_EQ(file.cloud.count(), kept);
    EXPECT_EQ(file.cloud.sh.size(), kept);
    EXPECT_EQ(file.repairs.not_finite, cases.size() + 1 - kept);
    EXPECT_EQ(file.repairs.no_rotation, 1u);
    EXPECT_EQ(file.cloud.opacity[1], 1);
    EXPECT_EQ(file.cloud.opacity[2], 0);
    EXPECT_EQ(file.cloud.scale[3].x, 0);
    std::vector<double> lost = one_row;
    lost[0] = nan;
    EXPECT_NE(reason<InputError>([&] { parse_splat_ply(little(lost), "l.ply"); }).find("none of"),
              std::string::npos);
}

TEST(SplatPly, HeadersThatLackSomethingSayWhat)
{
    const auto said = [](const std::string& bytes) {
        return reason<InputError>([&] { parse_splat_ply(bytes, "f.ply"); });
    };
    const auto tells = [&](const std::string& bytes, const std::string& what) {
        const std::string text = said(bytes);
        EXPECT_NE(text.find("f.ply"), std::string::npos) << text;
        EXPECT_NE(text.find(what), std::string::npos) << text;
    };
    for (const char* name : {"x", "opacity", "scale_1", "rot_3", "f_dc_1"}) {
        Names names = plain;
        names.erase(std::find(names.begin(), names.end(), name));
        tells(little(std::vector<double>(13, 1), names), std::string("\"") + name + "\"");
    }
    Names more = plain;
    more.push_back("f_rest_0");
    tells(little(std::vector<double>(15, 1), more), "f_rest_");
    more.back() = "x";
    tells(little(std::vector<double>(15, 1), more), "twice");
    tells(header("binary_little_endian", 1, plain, "int") + std::string(56, '\0'), "whole numbers");
    tells(header("binary_little_endian", 1, plain, "list uchar float") + std::string(14, '\0'),
          "a list");
    tells(header("binary_little_endian", 0, plain), "none");
    tells(little(one_row) + "x", "1 bytes more");
    const std::string whole = little(one_row);
    tells(whole.substr(0, whole.size() - 1), "the end of the file");
    tells(whole.substr(0, whole.size() - 2), "bytes left");
    tells(header("ascii", 1, plain) + "1 2 3 four 5 6 7 8 9 10 11 12 13 14", "a number");
}

TEST(SplatPly, CountsThatTheFileCannotHoldAreRefusedAtOnce)
{
    for (const char* rows : {"1000000000000000000", "4000000000", "99999999999999999999", "-1"}) {
        std::string head = header("binary_little_endian", 77, plain);
        head.replace(head.find("77"), 2, rows);
        EXPECT_THROW(parse_splat_ply(head + std::string(56, '\0'), "big.ply"), InputError);
    }
}

TEST(SplatPly, TheLargestHalfAxesAreReadAgain)
{
    SplatCloud cloud = drawn(1, 0, 1);
    cloud.scale[0] = {std::numeric_limits<float>::max(), 1e38f, 1e-45f};
    const Vec3<float> back = parse_splat_ply(splat_ply_bytes(cloud), "l.ply").cloud.scale.at(0);
    EXPECT_NEAR(back.x / std::numeric_limits<float>::max(), 1, 1e-4);
    EXPECT_NEAR(back.y / 1e38f, 1, 1e-4);
}

TEST(SplatPly, WhatIsWrittenIsRead)
{
    for (int degree = 0; degree <= 3; ++degree) {
        SplatCloud cloud = drawn(50, degree, 1);
        cloud.antialiased = degree % 2;
        cloud.opacity[0] = 0;
        cloud.opacity[1] = 1;
        cloud.scale[2].y = 0;
        const std::string bytes = splat_ply_bytes(cloud);
        const SplatCloud back = parse_splat_ply(bytes, "w.ply").cloud;
        EXPECT_EQ(back.degree, degree);
        EXPECT_EQ(back.antialiased, cloud.antialiased);
        EXPECT_EQ(back.opacity[0], 0);
        EXPECT_EQ(back.opacity[1], 1);
        EXPECT_EQ(back.scale[2].y, 0);
        cloud.scale[2].y = 1;
        SplatCloud same = back;
        same.scale[2].y = 1;
        const Apart most = apart(cloud, same);
        EXPECT_EQ(most.centre, 0);
        EXPECT_EQ(most.dc, 0);
        EXPECT_EQ(most.rest, 0);
        // A float's logarithm of up to 10 is exact to 2^-21, its logit to as much.
        EXPECT_LT(most.scale, 1.5e-6);
        EXPECT_LT(most.opacity, 1e-6);
        EXPECT_LT(most.rotation, 1e-6);
        // 248 bytes a splat at degree 3, all of them finite.
        const std::size_t row = sizeof(float) * std::size_t(17 + 3 * (harmonics(degree) - 1));
        EXPECT_EQ(bytes.size() - (bytes.find("end_header") + 11), 50 * row);
        std::vector<float> numbers(50 * row / 4);
        std::memcpy(numbers.data(), bytes.data() + bytes.size() - 50 * row, 50 * row);
        for (float number : numbers) EXPECT_TRUE(std::isfinite(number));
    }
}

}  // namespace
}  // namespace knead
