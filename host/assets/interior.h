// The interior of a solid: depth, colour, and splats that become visible when the object is cut.
#pragma once
#include "host/assets/solid.h"

namespace knead {

// Distance of the solid's nodes from its surface [m], 0 outside, by the eikonal equation and
// first-order fast sweeping [Zhao 2005].
std::vector<float> depths(const Solid& solid);

// Interior colours: spherical-harmonic coefficients of degree 0 at the solid's nodes. Dirichlet
// condition: nodes near visible splats have the coefficients of these splats. Elsewhere the
// coefficients solve Laplace's equation, by successive over-relaxation [Young 1954], with zero flux
// through the surface where there is no splat. By the maximum principle each channel stays within
// the range of the visible splats. Memory: 40 bytes per node. Bitwise equal for any number of
// threads.
std::vector<Vec3<float>> inner_colours(const SplatCloud& cloud,
                                       const std::vector<std::uint32_t>& kept, const Solid& solid,
                                       const std::vector<float>& depth);

struct InteriorOptions {
    double spacing = 0;  // spacing of the finer of two lattices of splats [m], above 0
    double min_depth_in_half_axes = 2.5;  // minimum depth of a centre, in half axes
    std::size_t max_count = 200000;
    unsigned seed = 1;
};
struct Interior {
    std::vector<Vec3<double>> centre;  // [m]
    std::vector<float> half_axis;      // [m]
    double spacing = 0;                // as used [m]: larger than requested if max_count requires
                                       // it
};

// Half axis relative to the distance between neighbours, which is twice `spacing` where the solid
// is deep enough.
constexpr double interior_half_axis = 0.6;
Interior interior_splats(const Solid& solid, const std::vector<float>& depth,
                         const InteriorOptions& options);

}  // namespace knead
