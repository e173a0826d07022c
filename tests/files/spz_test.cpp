// SPZ: files by hand after the description of the format, and what is written within its steps.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/base/errors.h"
#include "host/files/gzip.h"
#include "tests/files/splat_cases.h"
#include "tests/reason.h"

namespace knead {
namespace {

void expect_spz_by_hand(const SplatFile& file, std::uint32_t version)
{
    const SplatCloud& c = file.cloud;
    ASSERT_EQ(c.count(), 2u);
    ASSERT_EQ(c.degree, 1);
    // Right, up, back becomes right, down, forward.
    EXPECT_EQ(length(c.centre[0] - Vec3<float>{1, -2, 3}), 0);
    EXPECT_EQ(length(c.centre[1] - Vec3<float>{-1.0f / 4096, 0, 0}), 0);
    EXPECT_NEAR(c.opacity[0], 0.2, 1e-6);
    EXPECT_EQ(c.opacity[1], 1);
    EXPECT_NEAR(c.sh[0].x, 0.5 / 0.15, 1e-5);
    EXPECT_NEAR(c.sh[0].y, -0.5 / 0.15, 1e-5);
    EXPECT_NEAR(c.scale[0].x, 1, 1e-6);
    EXPECT_NEAR(c.scale[0].y, std::exp(-1.0), 1e-6);
    EXPECT_NEAR(c.scale[0].z, std::exp(-10.0), 1e-9);
    if (version == 2) {  // half a turn about x; 128 stands for 1/255
        EXPECT_LT(turn_between(c.rotation[0], {0, 1, 0, 0}), 2e-5);
        EXPECT_LT(turn_between(c.rotation[1], {0, 0, 0, 1}), 2e-5);
    } else {
        const float r = float(std::sqrt(0.5));
        EXPECT_LT(turn_between(c.rotation[0], {r, r, 0, 0}), 1e-6);
        EXPECT_LT(turn_between(c.rotation[1], {r, 0, r, 0}), 1e-6);
    }
    // y, z, x of degree 1; the first two change their signs.
    for (int k = 0; k < 3; ++k) {
        const float sign = k < 2 ? -1.0f : 1.0f;
        EXPECT_EQ(c.sh[std::size_t(1 + k)].x, sign * float(3 * k - 8) / 16);
        EXPECT_EQ(c.sh[std::size_t(5 + k)].z, sign * float(3 * k + 11 - 8) / 16);
    }
}

TEST(Spz, AFileByHandIsReadInTheOpenAndPacked)
{
    for (std::uint32_t version : {2u, 3u}) {
        const std::string bytes = SpzByHand{.version = version}.bytes();
        expect_spz_by_hand(parse_spz(bytes, "open.spz"), version);
        expect_spz_by_hand(parse_spz(gzipped(bytes), "packed.spz"), version);
    }
    EXPECT_TRUE(parse_spz(SpzByHand{.flags = 1}.bytes(), "a.spz").cloud.antialiased);
}

TEST(Spz, ExtensionsArePassedOverUnlessTheyNameOtherAxes)
{
    const auto record = [](std::uint32_t type, std::uint32_t size, const std::string& content) {
        return bytes_of(std::vector<std::uint32_t>{type, size}) + content;
    };
    SpzByHand by_hand{.flags = 2};
    by_hand.behind = record(0xadbe0002u, 12, std::string(12, 'x')) + record(7, 0, "");
    expect_spz_by_hand(parse_spz(gzipped(by_hand.bytes()), "e.spz"), 3);
    // System 0x64636261.
    for (const std::string& behind : {record(0xadbe0003u, 4, "abcd"), record(7, 5, "abcd"),
                                      record(7, 0xffffffffu, ""), std::string("abc")}) {
        by_hand.behind = behind;
        EXPECT_THROW(parse_spz(by_hand.bytes(), "e.spz"), InputError);
    }
}

TEST(Spz, OtherVersionsAndAbsurdHeadersSayWhy)
{
    const auto said = [](const SpzByHand& by_hand) {
        return reason<InputError>([&] { parse_spz(gzipped(by_hand.bytes()), "f.spz"); });
    };
    EXPECT_NE(said({.version = 4}).find("in the open"), std::string::npos);
    EXPECT_NE(said({.version = 0}).find("version 1 to 4"), std::string::npos);
    EXPECT_NE(said({.version = 5}).find("version 1 to 4"), std::string::npos);
    EXPECT_NE(said({.flags = 0x80}).find("tree of levels"), std::string::npos);
    EXPECT_NE(said({.degree = 5}).find("degree"), std::string::npos);
    EXPECT_NE(said({.fraction_bits = 24}).find("fraction"), std::string::npos);
    EXPECT_NE(said({.count = 0xffffffffu}).find("4294967295 splats"), std::string::npos);
    EXPECT_NE(said({.count = 1}).find("more"), std::string::npos);
    EXPECT_NE(said({.count = 3}).find("3 splats"), std::string::npos);
    EXPECT_NE(said({.behind = "x"}).find("more"), std::string::npos);
    const std::string packed = gzipped(SpzByHand{}.bytes());
    EXPECT_THROW(parse_spz(packed + "x", "f.spz"), InputError);
    EXPECT_THROW(parse_spz(packed.substr(0, packed.size() - 1), "f.spz"), InputError);
    EXPECT_THROW(parse_spz("", "f.spz"), InputError);
}

// Splats of zeros pack a thousandfold: a million bytes of them pass, eighty do not.
TEST(Spz, WhatUnpacksBeyondReasonIsRefusedByItsHeader)
{
    const auto zeros = [](std::uint32_t count) {
        const SpzByHand by_hand{.count = count, .degree = 0};
        return gzipped(by_hand.bytes().substr(0, 16) + std::string(20 * std::size_t(count), '\0'));
    };
    EXPECT_EQ(parse_spz(zeros(50'000), "z.spz").cloud.count(), 50'000u);
    EXPECT_NE(reason<InputError>([&] { parse_spz(zeros(4'000'000), "z.spz"); }).find("at most"),
              std::string::npos);
}

// The half turn about x that stands between the format's axes and a cloud's, as signs.
TEST(Spz, TheSignsOfHarmonicsAreThoseOfAHalfTurn)
{
    SplatCloud cloud = drawn(1, 3, 3);
    for (Vec3<float>& c : cloud.sh) c = {0.5f, 0.25f, -0.5f};
    const std::string all = gunzipped(spz_bytes(cloud, "s.spz"), "s.spz", 1 << 20);
    const std::string written = all.substr(all.size() - 45);
    std::array<Vec3<double>, 16> turned{};
    const Mat3<double> half_turn{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
    turn_harmonics(
        3, half_turn, [&](int k) { return cast<double>(cloud.sh[std::size_t(k)]); },
        [&](int k, Vec3<double> v) { turned[std::size_t(k)] = turned[std::size_t(k)] + v; });
    for (std::size_t k = 1; k < 16; ++k)
        EXPECT_NEAR((double(std::uint8_t(written[3 * (k - 1)])) - 128) / 128, turned[k].x, 1e-12)
            << k;
}

TEST(Spz, WhatIsWrittenIsReadWithinItsSteps)
{
    for (int version : {2, 3, 4})
        for (int degree = 0; degree <= 3; ++degree) {
            SplatCloud cloud = drawn(500, degree, 4);
            cloud.antialiased = degree % 2;
            const std::string bytes = spz_bytes(cloud, "w.spz", version);
            EXPECT_EQ(bytes, spz_bytes(cloud, "w.spz", version));
            const SplatCloud back = parse_spz(bytes, "w.spz").cloud;
            EXPECT_EQ(back.degree, degree);
            EXPECT_EQ(back.antialiased, cloud.antialiased);
            const Apart most = apart(cloud, back);
            EXPECT_LE(most.centre, 0x1p-16);  // centres reach to 2
            EXPECT_LE(most.opacity, 0.5 / 255 + 1e-6);
            EXPECT_LE(most.dc, 0.5 / 255 / 0.15 + 1e-6);
            EXPECT_LE(most.rest, 0.5 / 128 + 1e-6);
            EXPECT_LE(most.scale, 0.5 / 16 + 1e-5);
            // Steps of 1/127.5 in x, y, z, where w may be small; of sqrt(1/2)/511.
            EXPECT_LE(most.rotation, version == 2 ? 0.02 : 3e-6);
        }
}

TEST(Spz, CentresFarAwayHaveCoarserStepsAndTooFarOnesAreRefused)
{
    for (float far : {0.0f, 1e-3f, 0.2f, 30.0f, 1e4f, 4e6f}) {
        SplatCloud cloud = drawn(2, 0, 5);
        cloud.centre = {{far, -far, 0}, {0, 0, far}};
        const SplatCloud back = parse_spz(spz_bytes(cloud, "f.spz"), "f.spz").cloud;
        EXPECT_LE(apart(cloud, back).centre, std::max(far / 65536, 0x1p-24f)) << far;
    }
    SplatCloud cloud = drawn(1, 0, 6);
    cloud.centre[0].x = 5e6f;
    EXPECT_THROW(spz_bytes(cloud, "f.spz"), InputError);
}

}  // namespace
}  // namespace knead
