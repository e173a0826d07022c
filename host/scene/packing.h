// Particles of equal volume that fill a shape evenly up to its surface. Each stratum of a lattice
// inside the shape holds one particle (strata.h). Some of the strata cut by the surface hold one
// too: as many as needed to fill the remaining volume. These particles and the two layers below
// them are then moved to minimise the difference between their density, smoothed like the density
// of the surface, and the density of the shape.  (35)
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "cuda/math/vec.h"

namespace knead {

// Depth of a point below the shape's surface [m], negative outside: first-order accurate near the
// surface, elsewhere a lower bound. Must be thread-safe.
using Depth = std::function<double(Vec3<double>)>;

struct Packing {
    double h = 0;         // edge of a stratum [m]; a particle's volume is its cube
    double per_cell = 8;  // particles per cell of the solver
    unsigned seed = 1;
    std::size_t object = 0;
    Int3 low{}, high{};  // strata that may intersect the shape, from `low` up to but excluding
                         // `high`; stratum s spans h s to h (s + 1)
};

// Positions of the particles in the order of their strata, all inside the shape where it is convex
// or smooth. Bitwise equal for any number of threads. Memory: 16 bytes per stratum of the box.
std::vector<Vec3<double>> packed(const Packing& packing, const Depth& depth);

}  // namespace knead
