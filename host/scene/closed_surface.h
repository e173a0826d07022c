// Triangles as a closed, evenly oriented surface.
#pragma once
#include <string>
#include <vector>

#include "cuda/math/vec.h"

namespace knead {

struct ClosedSurface {
    std::vector<Vec3<double>> vertices;
    std::vector<Int3> triangles;        // those of the holes come last
    double area = 0, open_area = 0;     // open_area: of the largest part, the holes'
    std::size_t holes = 0, pieces = 0;  // pieces: connected by edges of two triangles
    Vec3<double> open_at{};             // the middle of an edge of the largest hole
};

// Coincident vertices become one, triangles without three of them are left out. Neighbours across
// an edge of two triangles get the same orientation, that of most triangles of their piece. Edges
// that then have more triangles in one direction than in the other are the borders of holes, each
// of which is closed by a fan around its middle.
ClosedSurface closed_surface(const std::vector<Vec3<double>>& vertices,
                             const std::vector<Int3>& triangles);

}  // namespace knead
