// The steps from particles to a surface: density on a box of nodes, triangles, smoothing.
#pragma once
#include <vector>

#include "cuda/mpm/lattice.h"
#include "host/surface/mesh.h"

namespace knead {

// Densities of the nodes low <= n < low + size of a lattice, x fastest; every other node is empty.
// The outermost layer of the box is empty too, so a surface inside it is closed.
struct Field {
    Int3 low{}, size{};
    float dx = 1;              // spacing [m]
    std::vector<float> value;  // in units of rest density; size.x * size.y * size.z
};

// What one particle adds to the density.
struct Deposit {
    Vec3<float> x;  // [m]
    float volume;   // at rest [m^3]
};

// The quadratic B-spline, widened for particles as large as the largest. All deposits must be
// `inside` the lattice (cuda/surface/density.h). The same bits for any number of threads.
Field density(const std::vector<Deposit>& deposits, const Lattice<float>& lattice);

// Closed, every edge shared by exactly two triangles, no vertex unused. Without normals. Throws
// std::runtime_error where the outermost layer of the field is not empty.
Mesh isosurface(const Field& field, float iso);

// Moves the vertices of a closed mesh and gives every vertex its normal.
void smooth(Mesh& mesh, Smoothing smoothing, int iterations);

}  // namespace knead
