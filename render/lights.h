// The lamps of a picture: a key light (a disk) and a sky dome, both sampled by directions with a
// shadow map each. The sum over the dome is ambient occlusion by visibility.
#pragma once
#include <array>
#include <cmath>

#include "render/geometry.h"

namespace knead {

// Number of each kind; multiples of 4, because each of a pixel's four samples uses a quarter.
constexpr int key_lamps = 32, dome_lamps = 64;
constexpr int lamps = key_lamps + dome_lamps;

// Uniform block layout (std140): three rows that transform a position to shadow map coordinates, in
// [0, 1] over the lit ball, and the direction towards the lamp.
struct Lamp {
    float row[3][4];
    float towards[4];
};
using Lamps = std::array<Lamp, lamps>;

inline Lamp lamp(Vec3<float> towards, const Ball& ball)
{
    const Vec3<float> u = orthogonal(towards), v = cross(towards, u);
    const Vec3<float> axes[3] = {u, v, -towards};  // seen from the lamp; depth grows away from it
    Lamp l{};
    for (int i = 0; i < 3; ++i) {
        const Vec3<float> a = (0.5f / ball.radius) * axes[i];
        const float offset = 0.5f - dot(a, ball.centre);
        const float row[4] = {a.x, a.y, a.z, offset};
        for (int k = 0; k < 4; ++k) l.row[i][k] = row[k];
    }
    const float direction[4] = {towards.x, towards.y, towards.z, 0};
    for (int k = 0; k < 4; ++k) l.towards[k] = direction[k];
    return l;
}

constexpr float golden_angle = 2.39996323f;  // [rad]

// The k-th of n points spread evenly over a disk or dome by the golden angle (a Fibonacci spiral),
// permuted so that lamps of equal index modulo 4 are spread evenly as well.
inline int dealt(int k) { return 4 * (k / 4) + (k + k / 4) % 4; }

// `key` is the unit direction towards the middle of the key light, `spread` its angular radius
// [rad].
inline Lamps lamps_about(const Ball& ball, Vec3<float> key, float spread)
{
    const float tau = 6.2831853f;
    const Vec3<float> u = orthogonal(key), v = cross(key, u);
    Lamps all{};
    for (int k = 0; k < key_lamps; ++k) {
        const float r = std::tan(spread) * std::sqrt((float(k) + 0.5f) / key_lamps);
        const float turn = golden_angle * float(k);
        const Vec3<float> d = key + r * (std::cos(turn) * u + std::sin(turn) * v);
        all[dealt(k)] = lamp((1 / length(d)) * d, ball);
    }
    for (int k = 0; k < dome_lamps; ++k) {
        const float y = (float(k) + 0.5f) / dome_lamps, r = std::sqrt(1 - y * y);
        const float turn = std::fmod(golden_angle * float(k), tau);
        all[key_lamps + dealt(k)] = lamp({r * std::cos(turn), y, r * std::sin(turn)}, ball);
    }
    return all;
}

}  // namespace knead
