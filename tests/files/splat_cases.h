// What the tests of splat files share: small files by hand, drawn clouds, and how far two clouds
// are apart.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "host/files/splat_file.h"
#include "tests/solver/samples.h"

namespace knead {

// Numbers as bytes, the lowest first.
template <class T>
std::string bytes_of(const std::vector<T>& values)
{
    return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

// The same, the highest first.
template <class T>
inline std::string swapped(const std::vector<T>& values)
{
    std::string all;
    for (T v : values) {
        std::string one = bytes_of(std::vector<T>{v});
        std::reverse(one.begin(), one.end());
        all += one;
    }
    return all;
}

using Names = std::vector<std::string>;
inline const Names plain{"x",       "y",       "z",       "f_dc_0", "f_dc_1", "f_dc_2", "opacity",
                         "scale_0", "scale_1", "scale_2", "rot_0",  "rot_1",  "rot_2",  "rot_3"};
// One splat in that order: 1, 2, -3; half axes 1, e, 1 / e; opacity 1/2; a quarter turn about x.
inline const std::vector<double> one_row{1, 2, -3, 0.5, 0.25, -1, 0, 0, 1, -1, 2, 2, 0, 0};

inline std::string properties(const Names& names, const std::string& type = "float")
{
    std::string text;
    for (const std::string& name : names) text += "property " + type + " " + name + "\n";
    return text;
}

inline std::string header(const std::string& format, std::size_t rows, const Names& names,
                          const std::string& type = "float", const std::string& comment = "")
{
    return "ply\nformat " + format + " 1.0\n" + comment + "element vertex " + std::to_string(rows) +
           "\n" + properties(names, type) + "end_header\n";
}

inline std::string little(const std::vector<double>& row, const Names& names = plain)
{
    return header("binary_little_endian", row.size() / names.size(), names) +
           bytes_of(std::vector<float>(row.begin(), row.end()));
}

inline SplatCloud drawn(std::size_t count, int degree, std::uint64_t seed)
{
    Draw draw(seed);
    SplatCloud c;
    c.degree = degree;
    for (std::size_t i = 0; i < count; ++i) {
        c.centre.push_back(cast<float>(draw.vector(2)));
        c.scale.push_back(
            cast<float>(Vec3<double>{draw.power(-4, 1), draw.power(-4, 1), draw.power(-4, 1)}));
        c.rotation.push_back(cast<float>(quaternion(draw.rotation())));
        c.opacity.push_back(float(draw.in(0, 1)));
        for (int k = 0; k < harmonics(degree); ++k) c.sh.push_back(cast<float>(draw.vector(0.99)));
    }
    return c;
}

// 1 - |p . q|: half the square of half the angle between two rotations.
inline double turn_between(Quat<float> p, Quat<float> q)
{
    const double cosine =
        double(p.w) * q.w + double(p.x) * q.x + double(p.y) * q.y + double(p.z) * q.z;
    return 1 - std::abs(cosine);
}

// How far clouds are apart at most; half axes by their logarithms.
struct Apart {
    double centre = 0, scale = 0, rotation = 0, opacity = 0, dc = 0, rest = 0;
};

inline Apart apart(const SplatCloud& a, const SplatCloud& b)
{
    Apart most;
    EXPECT_EQ(a.count(), b.count());
    if (a.count() != b.count()) return most;
    const auto raise = [](double& worst, double x) { worst = std::max(worst, x); };
    const auto each = [](Vec3<float> u, Vec3<float> v) {
        const Vec3<double> d = cast<double>(u) - cast<double>(v);
        return std::max({std::abs(d.x), std::abs(d.y), std::abs(d.z)});
    };
    const auto logs = [](Vec3<float> s) {
        return Vec3<float>{std::log(s.x), std::log(s.y), std::log(s.z)};
    };
    for (std::size_t i = 0; i < a.count(); ++i) {
        raise(most.centre, each(a.centre[i], b.centre[i]));
        raise(most.scale, each(logs(a.scale[i]), logs(b.scale[i])));
        raise(most.rotation, turn_between(a.rotation[i], b.rotation[i]));
        raise(most.opacity, std::abs(double(a.opacity[i]) - b.opacity[i]));
        for (std::size_t k = 0; k < std::size_t(harmonics(std::min(a.degree, b.degree))); ++k)
            raise(k == 0 ? most.dc : most.rest,
                  each(a.sh[i * std::size_t(harmonics(a.degree)) + k],
                       b.sh[i * std::size_t(harmonics(b.degree)) + k]));
    }
    return most;
}

// A file by the description of the format, degree 1, two splats, in the open and in gzip.
struct SpzByHand {
    std::uint32_t version = 3, count = 2;
    std::uint8_t degree = 1, fraction_bits = 12, flags = 0;
    std::string behind = "";

    std::string bytes() const
    {
        std::string all = "NGSP" + bytes_of(std::vector<std::uint32_t>{version, count}) +
                          bytes_of(std::vector<std::uint8_t>{degree, fraction_bits, flags, 0});
        // Centres (1, 2, -3) and (-1/4096, 0, 0) in 1/4096: 0x1000, 0x2000, -0x3000; -1.
        all += bytes_of(std::vector<std::uint8_t>{0, 0x10, 0, 0, 0x20, 0, 0, 0xd0, 0xff});
        all += bytes_of(std::vector<std::uint8_t>{0xff, 0xff, 0xff, 0, 0, 0, 0, 0, 0});
        all += bytes_of(std::vector<std::uint8_t>{51, 255});                  // opacities
        all += bytes_of(std::vector<std::uint8_t>{255, 0, 51, 0, 0, 0});      // colours
        all += bytes_of(std::vector<std::uint8_t>{160, 144, 0, 80, 80, 80});  // e^0, e^-1, e^-10
        if (version == 2)
            all += bytes_of(std::vector<std::uint8_t>{255, 128, 128, 128, 128, 0});
        else  // 3, largest w: x 511, y 0, z 0; largest y: x 0, z 0, w -511
            all += bytes_of(std::vector<std::uint32_t>{3u << 30 | 511u << 20, 1u << 30 | 1023u});
        for (int k = 0; k < 18; ++k) all.push_back(char(128 + 8 * k - 64));
        return all + behind;
    }
};

// .ksplat, by the description of the format: one section of degree 1, with a full bucket of one
// splat and a partial one of two.
inline std::string ksplat_of_level(int level)
{
    std::string bytes(4096 + 1024, '\0');
    const auto put = [&](std::size_t at, auto value) {
        std::copy_n(reinterpret_cast<const char*>(&value), sizeof value, bytes.data() + at);
    };
    put(1, std::uint8_t(1));
    put(4, std::uint32_t(1)), put(12, std::uint32_t(3)), put(16, std::uint32_t(3));
    put(20, std::uint16_t(level));
    const std::size_t s = 4096;
    put(s, std::uint32_t(3)), put(s + 4, std::uint32_t(3)), put(s + 8, std::uint32_t(1));
    put(s + 12, std::uint32_t(2)), put(s + 16, 5.0f), put(s + 20, std::uint16_t(12));
    put(s + 32, std::uint32_t(1)), put(s + 36, std::uint32_t(1)), put(s + 40, std::uint16_t(1));
    bytes += bytes_of(std::vector<std::uint32_t>{2});  // length of the partial bucket
    bytes += bytes_of(std::vector<float>{10, 20, 30, -1, -2, -3});
    for (int i = 0; i < 3; ++i) {
        const auto reals = [&](const std::vector<float>& floats,
                               const std::vector<std::uint16_t>& halves) {
            bytes += level == 0 ? bytes_of(floats) : bytes_of(halves);
        };
        // 32767 is the bucket's centre, 65534 half a block beyond.
        reals({float(i), 2, 3}, {32767, 65534, 0});
        reals({1, 2, 0.5f}, {0x3c00, 0x4000, 0x3800});
        reals({0, 1, 0, 0}, {0, 0x3c00, 0, 0});  // about x
        bytes += bytes_of(std::vector<std::uint8_t>{255, 0, 51, 204});
        // Red: 1, 2, 0.5; green: 0; blue: -1.
        if (level == 2)
            bytes += bytes_of(std::vector<std::uint8_t>{212, 255, 170, 128, 128, 128, 43, 43, 43});
        else
            reals({1, 2, 0.5f, 0, 0, 0, -1, -1, -1},
                  {0x3c00, 0x4000, 0x3800, 0, 0, 0, 0xbc00, 0xbc00, 0xbc00});
    }
    return bytes;
}

}  // namespace knead
