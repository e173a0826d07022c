// A cloud of splats.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cuda/splats/gaussian.h"

namespace knead {

// A file's unit of length is taken for a metre, its axes as they are: mostly right, down, forward.
struct SplatCloud {
    int degree = 0;            // of the harmonics, at most max_sh_degree
    bool antialiased = false;  // made for a screen filter that keeps the opacity of small ones
    std::vector<Vec3<float>> centre;    // [m]
    std::vector<Quat<float>> rotation;  // unit
    std::vector<Vec3<float>> scale;     // half axes [m], at least 0
    std::vector<float> opacity;         // 0 to 1
    std::vector<Vec3<float>> sh;  // harmonics(degree) for each splat; red, green, blue of each

    std::size_t count() const { return centre.size(); }
};

void resize(SplatCloud& cloud, std::size_t count);
void reserve(SplatCloud& cloud, std::size_t count);
// Splat `at` becomes splat i of the other cloud, of the same degree.
void set_splat(SplatCloud& to, std::size_t at, const SplatCloud& from, std::size_t i);

// Puts the splats behind the first `kept` into an order in which neighbours in memory mostly are
// neighbours in space.  [Morton 1966]
void sort_by_place(SplatCloud& cloud, std::size_t kept = 0);

// The splats of these indices, in their order.
SplatCloud picked(const SplatCloud& cloud, const std::vector<std::uint32_t>& indices);

}  // namespace knead
