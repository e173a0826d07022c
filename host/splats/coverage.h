// How well splats cover what they should.
#pragma once
#include <cstddef>
#include <vector>

#include "cuda/splats/eye.h"
#include "host/splats/raster.h"

namespace knead {

// Depth along the eye's forward axis of the nearest of a mesh's triangles at each pixel's centre,
// rows from the top; no_depth where there is none [m]. Triangles that come nearer than `near` [m]
// are left out.
std::vector<float> mesh_depths(const Eye<float>& eye, const std::vector<Vec3<float>>& vertices,
                               const std::vector<Int3>& triangles, double near = 0.01);

struct Coverage {
    std::size_t pixels = 0;   // that are to be covered
    std::size_t open = 0;     // of these, where it is not
    std::size_t largest = 0;  // pixels of the largest hole, of open pixels side by side
    double least_alpha = 1;   // where it is least
    double mean_alpha = 1;

    double open_share() const { return pixels ? double(open) / double(pixels) : 0; }
};

// Of the pixels of a picture that a mesh covers, less a rim of so many pixels within its outline.
// Open is a pixel whose alpha is less than `least`, or whose depth is more than `slack` [m] behind
// the mesh. Throws std::invalid_argument where the picture is of another size.
Coverage coverage(const Picture& picture, const std::vector<float>& mesh, int rim,
                  double least = 0.9, double slack = 1e30);

}  // namespace knead
