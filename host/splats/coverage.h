// Measures how completely splats cover a surface.
#pragma once
#include <cstddef>
#include <vector>

#include "cuda/splats/eye.h"
#include "host/splats/raster.h"

namespace knead {

// Depth of a mesh along the eye's forward axis at each pixel's centre [m], rows from the top;
// no_depth where there is no triangle. Triangles closer than `near` [m] are omitted.
std::vector<float> mesh_depths(const Eye<float>& eye, const std::vector<Vec3<float>>& vertices,
                               const std::vector<Int3>& triangles, double near = 0.01);

struct Coverage {
    std::size_t pixels = 0;   // pixels that should be covered
    std::size_t open = 0;     // of these, pixels that are not
    std::size_t largest = 0;  // pixels of the largest connected hole
    double least_alpha = 1;   // minimum alpha
    double mean_alpha = 1;

    double open_share() const { return pixels ? double(open) / double(pixels) : 0; }
};

// Coverage of the pixels that a mesh covers, without a rim of `rim` pixels inside its outline. A
// pixel is open if its alpha is less than `least`, or its depth more than `slack` [m] behind the
// mesh. Throws std::invalid_argument if the sizes of picture and depths differ.
Coverage coverage(const Picture& picture, const std::vector<float>& mesh, int rim,
                  double least = 0.9, double slack = 1e30);

}  // namespace knead
