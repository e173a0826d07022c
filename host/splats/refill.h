// New splats where a tear or a cut has bared clay that none covers.
#pragma once
#include <vector>

#include "host/splats/carried.h"

namespace knead {

struct RefillOptions {
    double see_through = 0.25;  // light through the splats of a place: where more comes, it is bare
    std::size_t budget = 1000;  // new splats a call, the barest places first
    std::size_t capacity = ~std::size_t(0);  // splats in all
};

struct RefillReport {
    std::vector<GaussianBeside> added;
    std::size_t bare = 0;     // places at the clay's surface that were
    std::size_t waiting = 0;  // of these, still so, for want of budget or capacity
};

// Splats for bare places at the surface of objects that have splats. `spacing` [m] is that of each
// object's particles; 0: an object without splats. A particle lies at the surface where those
// within 2.2 spacings leave one side empty, which gives the normal. Of the splats whose centres lie
// within 1.5 spacings of it along the normal, what they let through in that direction is what is
// asked. A new splat is a disc of half axes 0.7, 0.7 and 0.35 spacings, half a spacing above the
// particle's centre less its own thickness, undeformed, of opacity 0.98, of the particle's object
// and label. Its colour is the mean of those of the object's splats within 4 spacings by inverse
// squared distance, of degree 0; where there are none, the object's mean. In the order of how bare
// places are, then of the particles: the same for any number of threads. Throws
// std::invalid_argument where the splats are not the Gaussians', one for each.
RefillReport refill(CarriedSplats& splats, std::vector<Gaussian<double>>& gaussians,
                    const std::vector<Particle<double>>& particles,
                    const std::vector<double>& spacing, const RefillOptions& options,
                    const WallOptions& walls);

}  // namespace knead
