// Light from all directions, absorbed by a cloud of splats: which parts are visible from outside,
// and from which side.
#pragma once
#include "host/assets/grid.h"

namespace knead {

struct Light {
    std::vector<float> seen;  // fraction of a unit sky that reaches the node
    // Pressure of the light absorbed by a node, for a sky of pressure 1 on an open surface, per
    // spacing [1/m]: the sum over the thickness of an opaque convex surface is the inward normal,
    // independent of how often the surface is covered.
    std::vector<Vec3<float>> pressure;
};

// `extinction` [1/m] per node. Light is parallel, from `directions` points of a Fibonacci sphere
// [Gonzalez 2010], and is swept from slice to slice of nodes. Time: directions times nodes. Bitwise
// equal for any number of threads.
Light lit_from_all_sides(const Grid& grid, const std::vector<float>& extinction, int directions);

// Evenly distributed unit directions.
std::vector<Vec3<double>> fibonacci_sphere(int count);

}  // namespace knead
