// The view of an eye: an asymmetric frustum, as headsets have, and derived quantities.
#pragma once
#include <cmath>
#include <cstdint>
#include <cstring>

#include "cuda/math/rotation.h"

namespace knead {

template <class R>
struct Eye {
    Vec3<R> position;         // [m]
    Quat<R> rotation;         // unit; of its axes: right, down, forward
    R left, right, up, down;  // tangents of the sides: left < right, up < down
    int width, height;        // pixels
};

constexpr int max_eye_size = 16384;  // pixels a side

template <class R>
HD bool valid(const Eye<R>& e)
{
    const Quat<R> q = e.rotation;
    const R turn = q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z;
    const auto in = [](R tangent) { return std::fabs(tangent) < R(1000); };
    return length(e.position) < R(1e9) && std::fabs(turn - 1) < R(1e-3) && in(e.left) &&
           in(e.right) && in(e.up) && in(e.down) && e.right - e.left > R(1e-4) &&
           e.down - e.up > R(1e-4) && e.width > 0 && e.height > 0 && e.width <= max_eye_size &&
           e.height <= max_eye_size;
}

// An eye in the form used by projection. Pixel (i, j) has its centre at u = i, v = j.
template <class R>
struct Pinhole {
    Vec3<R> position;         // [m]
    Mat3<R> to_eye;           // rotates world directions to the eye's axes
    R fx, fy, cx, cy;         // u = fx x / z + cx, v = fy y / z + cy [pixels]
    R left, right, up, down;  // tangents
    int width, height;
};

template <class R>
HD Pinhole<R> pinhole(const Eye<R>& e)
{
    const R fx = R(e.width) / (e.right - e.left), fy = R(e.height) / (e.down - e.up);
    return {e.position,
            transpose(rotation(e.rotation)),
            fx,
            fy,
            -e.left * fx - R(0.5),
            -e.up * fy - R(0.5),
            e.left,
            e.right,
            e.up,
            e.down,
            e.width,
            e.height};
}

// Depth keys shared by both eyes: by distance from the midpoint between them, which is invariant
// under rotation of the head. 24 bits of the squared distance on a logarithmic scale: from `near`
// to 65536 times that, to one part in a million; larger distances are equal.
constexpr std::uint32_t no_depth_key = (1u << 24) - 1;  // of a splat that is in no view

// Rounds equally on host and device; `offset` is from the midpoint to the splat.
HD std::uint32_t depth_key(Vec3<float> offset, float near)
{
    const float squared =
        std::fma(offset.x, offset.x, std::fma(offset.y, offset.y, offset.z * offset.z));
    const float ratio = squared / (near * near);
    if (!(ratio > 1)) return 0;
    std::uint32_t bits;  // rise with the ratio: 8 bits of exponent, from 127 on, 23 of fraction
    std::memcpy(&bits, &ratio, sizeof bits);
    const std::uint32_t key = (bits - (127u << 23)) >> 4;
    return key < no_depth_key ? key : no_depth_key - 1;
}

}  // namespace knead
