// Light from all sides, absorbed by what a cloud of splats occupies: which of it is seen from
// outside, and from which side.
#pragma once
#include "host/assets/grid.h"

namespace knead {

struct Light {
    std::vector<float> seen;  // share of a unit sky that reaches the node
    // What the light that a node absorbs presses it with, of a sky whose pressure on an open
    // surface is 1, over the spacing [1/m]: its sum over an opaque convex surface's thickness is
    // the inward normal, however often the surface is covered.
    std::vector<Vec3<float>> pressure;
};

// `extinction` [1/m] at each node. Light comes parallel from `directions` points of a Fibonacci
// sphere [Gonzalez 2010], swept from slice to slice of nodes. Time goes with directions times
// nodes. The same bits for any number of threads.
Light lit_from_all_sides(const Grid& grid, const std::vector<float>& extinction, int directions);

// Unit directions, evenly spread.
std::vector<Vec3<double>> fibonacci_sphere(int count);

}  // namespace knead
