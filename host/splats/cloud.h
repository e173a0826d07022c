// A cloud of splats.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cuda/splats/gaussian.h"

namespace knead {

// One unit of a file is one metre; axes are kept, usually right, down, forward.
struct SplatCloud {
    int degree = 0;                     // degree of the spherical harmonics, at most max_sh_degree
    bool antialiased = false;           // trained with a screen filter that keeps total opacity
    std::vector<Vec3<float>> centre;    // [m]
    std::vector<Quat<float>> rotation;  // unit
    std::vector<Vec3<float>> scale;     // half axes [m], at least 0
    std::vector<float> opacity;         // 0 to 1
    std::vector<Vec3<float>> sh;        // harmonics(degree) RGB coefficients per splat

    std::size_t count() const { return centre.size(); }
};

void resize(SplatCloud& cloud, std::size_t count);
void reserve(SplatCloud& cloud, std::size_t count);
// Copies splat i of `from` to position `at`. Both clouds have the same degree.
void set_splat(SplatCloud& to, std::size_t at, const SplatCloud& from, std::size_t i);

// Sorts the splats after the first `kept` along a Morton curve, for memory locality.  [Morton 1966]
void sort_by_place(SplatCloud& cloud, std::size_t kept = 0);

// Returns the splats with these indices, in this order.
SplatCloud picked(const SplatCloud& cloud, const std::vector<std::uint32_t>& indices);

}  // namespace knead
