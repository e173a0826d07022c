// Foveated rendering: outside the gaze region one sample covers 2 x 2 or 4 x 4 pixels. All samples
// in a square of `fovea_square` pixels a side have the same size, so that warps do not diverge and
// splats are listed alike for all squares.
#pragma once
#include "cuda/splats/eye.h"

namespace knead {

constexpr int fovea_square = 64;  // pixels a side

// Radii as tangents, about (x, y), right of and below the eye's forward axis. Squares that overlap
// `fine` have one sample per pixel, others that overlap `middling` one per 2 x 2, the rest one per
// 4 x 4. By default all is fine.
template <class R>
struct Fovea {
    R x = 0, y = 0, fine = R(1e9), middling = R(1e9);
};

// Pixels a side covered by a sample in the square whose first pixel is (x, y): 1, 2 or 4. Rounds
// equally on host and device.
HD int fovea_step(const Fovea<float>& f, const Pinhole<float>& eye, int x, int y)
{
    const auto beside = [](float middle, float scale, float offset, int from) {  // [pixels]
        const float at = std::fma(middle, scale, offset);
        return clamp(at, float(from), float(from + fovea_square - 1)) - at;
    };
    // Tangents, up to a common factor.
    const float dx = eye.fy * beside(f.x, eye.fx, eye.cx, x);
    const float dy = eye.fx * beside(f.y, eye.fy, eye.cy, y);
    const float squared = std::fma(dx, dx, dy * dy), factor = eye.fx * eye.fy;
    const auto within = [&](float radius) {
        const float r = radius * factor;
        return squared <= r * r;
    };
    return within(f.fine) ? 1 : within(f.middling) ? 2 : 4;
}

// Offset from a sample's first pixel to the sampled position, the middle of its pixels.
HD float sample_offset(int step) { return 0.5f * float(step - 1); }

}  // namespace knead
