// Random rows of clay, and their equality to the bit.
#pragma once
#include <bit>
#include <cstring>
#include <random>
#include <vector>

#include "host/session/quantisation.h"

namespace knead {

template <class Numbers>
bool same_bytes(const Numbers& a, const Numbers& b)
{
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof a[0]) == 0);
}

inline bool same_rows(const ClayRows& a, const ClayRows& b)
{
    return a.count == b.count && same_bytes(a.planes, b.planes) && same_bytes(a.object, b.object) &&
           same_bytes(a.sides, b.sides) && same_bytes(a.gaussians, b.gaussians);
}

// Any bits: NaN with a payload, infinities, -0 and numbers too small to be normal among them.
inline float any_float(std::mt19937& random)
{
    const float odd[] = {0.0f,
                         -0.0f,
                         std::bit_cast<float>(0x7f800000u),
                         std::bit_cast<float>(0xff800000u),
                         std::bit_cast<float>(0x7fc12345u),
                         std::bit_cast<float>(0xffa00001u),
                         std::bit_cast<float>(0x00000001u)};
    return random() % 4 == 0 ? odd[random() % std::size(odd)]
                             : std::bit_cast<float>(std::uint32_t(random()));
}

inline ClayRows random_rows(std::mt19937& random, std::size_t particles, std::size_t gaussians)
{
    ClayRows rows;
    rows.count = particles;
    for (std::size_t i = 0; i < clay_planes * particles; ++i)
        rows.planes.push_back(any_float(random));
    for (std::size_t i = 0; i < particles; ++i) {
        rows.object.push_back(std::int32_t(random() % 3));
        rows.sides.push_back(std::uint32_t(random()) & ~(1u << 31));
    }
    for (std::size_t i = 0; i < gaussians; ++i) {
        const auto three = [&]() -> Vec3<float> {
            return {any_float(random), any_float(random), any_float(random)};
        };
        rows.gaussians.push_back({three(), {three(), three(), three()}, int(random() % 3), 7u});
    }
    return rows;
}

// Steps of three objects.
inline Quantisation coarse_steps()
{
    return {1.0f / 1024, {1, 1, 1}, {1000, 1000, 1000}, {0.25f, 0.5f}};
}

// The same particles elsewhere: a few numbers of `rows` are others.
inline ClayRows changed(std::mt19937& random, ClayRows rows, std::size_t numbers)
{
    for (std::size_t i = 0; i < numbers; ++i) {
        if (rows.count > 0) {
            rows.planes[random() % rows.planes.size()] = any_float(random);
            rows.sides[random() % rows.count] ^= 1u << random() % 31;
        }
        if (rows.gaussians.empty()) continue;
        Gaussian<float>& g = rows.gaussians[random() % rows.gaussians.size()];
        g.x.y = any_float(random), g.F.c.z = any_float(random), g.sides ^= 1u;
    }
    return rows;
}

}  // namespace knead
