// Where a picture may be coarse: beside what an eye looks at, one sample stands for 2 x 2 pixels,
// or for 4 x 4. A square of `fovea_square` pixels a side has one step throughout, so that a GPU's
// warps do not part, and splats are listed for it as for any other.
#pragma once
#include "cuda/splats/eye.h"

namespace knead {

constexpr int fovea_square = 64;  // pixels a side

// Radii as tangents, from (x, y), right of and below the eye's forward axis. Squares that reach
// into `fine` have every pixel, others that reach into `middling` one sample for 2 x 2, the rest
// one for 4 x 4. So as it stands all is fine.
template <class R>
struct Fovea {
    R x = 0, y = 0, fine = R(1e9), middling = R(1e9);
};

// Pixels a side that a sample stands for in the square whose first pixel is (x, y): 1, 2 or 4. Both
// sides round the same.
HD int fovea_step(const Fovea<float>& f, const Pinhole<float>& eye, int x, int y)
{
    const auto beside = [](float middle, float scale, float offset, int from) {  // [pixels]
        const float at = std::fma(middle, scale, offset);
        return clamp(at, float(from), float(from + fovea_square - 1)) - at;
    };
    // Tangents, but for a factor that all have.
    const float dx = eye.fy * beside(f.x, eye.fx, eye.cx, x);
    const float dy = eye.fx * beside(f.y, eye.fy, eye.cy, y);
    const float squared = std::fma(dx, dx, dy * dy), factor = eye.fx * eye.fy;
    const auto within = [&](float radius) {
        const float r = radius * factor;
        return squared <= r * r;
    };
    return within(f.fine) ? 1 : within(f.middling) ? 2 : 4;
}

// From a sample's first pixel to where it is taken: the middle of those that it stands for.
HD float sample_offset(int step) { return 0.5f * float(step - 1); }

}  // namespace knead
