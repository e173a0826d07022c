// The steps from particles to a surface: density on a box of nodes, triangles, smoothing.
#pragma once
#include <vector>

#include "cuda/mpm/lattice.h"
#include "host/surface/mesh.h"

namespace knead {

// Densities of the nodes low <= n < low + size of a lattice, x fastest; all other nodes are empty.
// The outermost layer of the box is empty, too, so a surface inside it is closed.
struct Field {
    Int3 low{}, size{};
    float dx = 1;              // spacing [m]
    std::vector<float> value;  // in units of rest density; size.x * size.y * size.z
};

// Contribution of one particle to the density.
struct Deposit {
    Vec3<float> x;  // [m]
    float volume;   // at rest [m^3]
};

// Density by quadratic B-splines, widened for the largest particles. Precondition: all deposits are
// `inside` the lattice (cuda/surface/density.h). Bitwise equal for any number of threads.
Field density(const std::vector<Deposit>& deposits, const Lattice<float>& lattice);

// Closed mesh without normals: every edge is shared by exactly two triangles, and every vertex is
// used. Throws std::runtime_error if the outermost layer of the field is not empty.
Mesh isosurface(const Field& field, float iso);

// Smooths a closed mesh and computes the vertex normals.
void smooth(Mesh& mesh, Smoothing smoothing, int iterations);

}  // namespace knead
