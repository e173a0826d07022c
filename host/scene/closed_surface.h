// Triangles as a closed, evenly oriented surface.
#pragma once
#include <string>
#include <vector>

#include "cuda/math/vec.h"

namespace knead {

struct ClosedSurface {
    std::vector<Vec3<double>> vertices;
    // From number `stated` on, those that close holes; their last two corners are on the border.
    std::vector<Int3> triangles;
    std::size_t stated = 0;
    double area = 0;                    // of the stated ones
    std::size_t holes = 0, pieces = 0;  // pieces: connected by edges of two triangles
};

// Coincident vertices become one, those without triangles and triangles without three of them are
// left out. Neighbours across an edge of two triangles get the same orientation, that of most
// triangles of their piece. Edges that then have more triangles in one direction than in the other
// are the borders of holes, each of which is closed by a fan around its middle.
ClosedSurface closed_surface(const std::vector<Vec3<double>>& vertices,
                             const std::vector<Int3>& triangles);

}  // namespace knead
