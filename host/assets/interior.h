// What lies under the surface of a solid: how deep, in which colour, and splats that show it when
// the object is cut.
#pragma once
#include "host/assets/solid.h"

namespace knead {

// Distance of the solid's nodes from its surface [m], 0 outside: the eikonal equation by fast
// sweeping, first order [Zhao 2005].
std::vector<float> depths(const Solid& solid);

// Coefficients of degree 0 at the solid's nodes: around the visible splats their own colours,
// inside the solution of Laplace's equation between them, by successive over-relaxation
// [Young 1954]; nothing flows through the surface where no splat is. Each channel stays between the
// extremes of the visible splats. Memory 40 bytes a node. The same for any number of threads.
std::vector<Vec3<float>> inner_colours(const SplatCloud& cloud,
                                       const std::vector<std::uint32_t>& kept, const Solid& solid,
                                       const std::vector<float>& depth);

struct InteriorOptions {
    double spacing = 0;  // of the finer splats [m], more than 0
    double bury = 2.5;   // half axes that a centre lies under the surface at least
    std::size_t max_count = 200000;
    unsigned seed = 1;
};
struct Interior {
    std::vector<Vec3<double>> centre;  // [m]
    std::vector<float> half_axis;      // [m]
    double spacing = 0;                // as used: wider than asked for where max_count bids it
};

// Half axes are `interior_half_axis` of the distance between neighbours, which is twice `spacing`
// wherever that is deep enough.
constexpr double interior_half_axis = 0.6;
Interior interior_splats(const Solid& solid, const std::vector<float>& depth,
                         const InteriorOptions& options);

}  // namespace knead
