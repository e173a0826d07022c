// Round trips through each pair of formats of splats that are written, and what a format cannot
// hold.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "host/base/json_reader.h"
#include "host/files/file_kind.h"
#include "host/files/webp.h"
#include "tests/files/splat_cases.h"
#include "tests/folder.h"

namespace knead {
namespace {

// How far one writing and reading moves the values of a cloud with centres within 2 m, half axes
// from 10^-4 to 10 m, and coefficients within 1. `shape` is that of the covariance, over its norm.
struct Format {
    const char* ending;
    int spz_version;
    double centre, shape, opacity, dc, rest;
};
constexpr double byte_step = 0.5 / 255 + 1e-6;
const Format all_formats[] = {
    {".ply", 3, 1e-6, 1e-5, 1e-6, 1e-6, 1e-6},
    // The box of a chunk in 1023 steps an axis, logarithms of half axes over ln 10^5 likewise.
    {".compressed.ply", 3, 4 / 2046.0 + 1e-6, 0.03, byte_step, 2 * byte_step / sh_constant,
     1 / 64.0},
    {".splat", 3, 0, 0.08, byte_step, byte_step / sh_constant, 0},
    // Half axes in steps of e^(1/16).
    {".spz", 3, 0x1p-16, 0.1, byte_step, byte_step / 0.15, 0.5 / 128 + 1e-6},
    {".spz", 4, 0x1p-16, 0.1, byte_step, byte_step / 0.15, 0.5 / 128 + 1e-6},
    // Half axes and coefficients in 256 codes.
    {".sog", 3, 3 * std::log(3.0) / 65535 + 1e-6, 0.15, byte_step, 1 / 64.0, 1 / 64.0},
    {".glb", 3, 1e-6, 1e-4, 1e-6, 1e-6, 4e-6}};

double norm(const Sym3<double>& s) { return std::sqrt(norm_squared(s)); }

// Compares with the splats at the nearest centres: some writers sort.
void expect_same(const SplatCloud& a, const SplatCloud& b, const Format& first,
                 const Format& second)
{
    const std::string pair = std::string(first.ending) + " to " + second.ending;
    ASSERT_EQ(a.count(), b.count()) << pair;
    const bool harmonics_kept = b.degree == a.degree;
    EXPECT_EQ(harmonics_kept, first.rest > 0 && second.rest > 0) << pair;
    const auto of = [](const SplatCloud& c, std::size_t i) {
        return covariance(
            Ellipsoid<double>{unit(cast<double>(c.rotation[i])), cast<double>(c.scale[i])});
    };
    Apart most;
    for (std::size_t i = 0; i < a.count(); ++i) {
        std::size_t k = 0;
        for (std::size_t n = 1; n < b.count(); ++n)
            if (length(b.centre[n] - a.centre[i]) < length(b.centre[k] - a.centre[i])) k = n;
        const auto raise = [](double& worst, double x) { worst = std::max(worst, x); };
        const Vec3<float> d = b.centre[k] - a.centre[i];
        for (const float part : {d.x, d.y, d.z}) raise(most.centre, std::abs(double(part)));
        const Sym3<double> p = of(a, i), q = of(b, k);
        raise(most.scale, norm(p + -1.0 * q) / norm(p));
        raise(most.opacity, std::abs(double(a.opacity[i]) - b.opacity[k]));
        const auto stride_a = std::size_t(harmonics(a.degree)),
                   stride_b = std::size_t(harmonics(b.degree));
        for (std::size_t j = 0; j < std::min(stride_a, stride_b); ++j) {
            const Vec3<float> c = b.sh[k * stride_b + j] - a.sh[i * stride_a + j];
            for (const float part : {c.x, c.y, c.z})
                raise(j == 0 ? most.dc : most.rest, std::abs(double(part)));
        }
    }
    EXPECT_LE(most.centre, first.centre + second.centre) << pair;
    EXPECT_LE(most.scale, first.shape + second.shape) << pair;
    EXPECT_LE(most.opacity, first.opacity + second.opacity) << pair;
    EXPECT_LE(most.dc, first.dc + second.dc) << pair;
    if (harmonics_kept) {
        EXPECT_LE(most.rest, first.rest + second.rest) << pair;
    }
}

using SplatRoundTrips = InFolder;

TEST_F(SplatRoundTrips, EachPairOfFormatsKeepsWhatBothHold)
{
    const SplatCloud cloud = drawn(200, 2, 31);
    for (const Format& first : all_formats)
        for (const Format& second : all_formats) {
            const auto named = [&](const Format& f, const char* name) {
                return path(name + std::to_string(f.spz_version) + f.ending);
            };
            if (!webp_available() &&
                (std::string(first.ending) == ".sog" || std::string(second.ending) == ".sog"))
                continue;
            const std::string a = named(first, "a"), b = named(second, "b");
            write_splats(a, cloud, first.spz_version);
            EXPECT_EQ(file_kind(a), FileKind::splats);
            write_splats(b, read_splats(a).cloud, second.spz_version);
            expect_same(cloud, read_splats(b).cloud, first, second);
        }
}

TEST_F(SplatRoundTrips, WhatAFormatCannotHoldIsSaid)
{
    SplatCloud cloud = drawn(10, 1, 32);
    const auto said = [&](const char* file) {
        std::string all;
        for (const std::string& loss : losses(cloud, file)) all += loss + "\n";
        return all;
    };
    for (const char* file : {"a.ply", "a.compressed.ply", "a.spz", "a.sog", "a.glb"})
        EXPECT_EQ(said(file), "") << file;
    EXPECT_NE(said("a.splat").find("harmonics above degree 0"), std::string::npos);
    cloud.antialiased = true;
    cloud.sh[1].y = 1.5f, cloud.sh[6].z = -5, cloud.sh[8].x = -4, cloud.scale[3].x = 1e-6f;
    EXPECT_EQ(said("a.ply"), "");
    EXPECT_NE(said("a.glb").find("antialiased"), std::string::npos);
    EXPECT_NE(said("a.splat").find("1 splats have colours"), std::string::npos);
    EXPECT_NE(said("a.spz").find("1 splats have colours"), std::string::npos);
    EXPECT_NE(said("a.spz").find("2 splats have harmonics"), std::string::npos);
    EXPECT_NE(said("a.spz").find("1 splats have half axes"), std::string::npos);
    EXPECT_NE(said("a.compressed.ply").find("1 splats have harmonics"), std::string::npos);
    EXPECT_EQ(said("a.sog"), "");
}

}  // namespace
}  // namespace knead
