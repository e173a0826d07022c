// Particles that fill a shape evenly up to its surface, all of one volume. A lattice of strata has
// one particle in each stratum inside (strata.h). Of those that the surface cuts, as many hold one
// as fill the volume; these and the two layers under them are then moved until their density,
// softened as the surface's is, differs least from the shape's own.  (35)
#pragma once
#include <cstddef>
#include <functional>
#include <vector>

#include "cuda/math/vec.h"

namespace knead {

// How far under the shape's surface a point lies [m], negative outside: to first order near the
// surface, elsewhere no more than it is. Called by several threads.
using Depth = std::function<double(Vec3<double>)>;

struct Packing {
    double h = 0;         // edge of a stratum [m]; a particle's volume is its cube
    double per_cell = 8;  // particles a cell of the solver has
    unsigned seed = 1;
    std::size_t object = 0;
    Int3 low{}, high{};  // strata that the shape may meet, from the first to before the second;
                         // stratum s reaches from h s to h (s + 1)
};

// In the order of their strata; inside the shape where that is convex or smooth. The same bits for
// any number of threads. Takes 16 bytes a stratum of the box.
std::vector<Vec3<double>> packed(const Packing& packing, const Depth& depth);

}  // namespace knead
