// Adds splats where a tear or a cut has exposed clay without splats.
#pragma once
#include <vector>

#include "host/splats/carried.h"

namespace knead {

struct RefillOptions {
    double see_through = 0.25;  // transmittance of the splats above which a place is bare
    std::size_t budget = 1000;  // new splats per call, barest places first
    std::size_t capacity = ~std::size_t(0);  // total splats
};

struct RefillReport {
    std::vector<GaussianBeside> added;
    std::size_t bare = 0;     // bare places on the clay's surface
    std::size_t waiting = 0;  // of these, not filled for lack of budget or capacity
};

// Fills bare places on the surface of objects that have splats. `spacing` [m] is the particle
// spacing of each object; 0: an object without splats. A particle is on the surface if its
// neighbours within 2.2 spacings leave one side empty, which gives the normal. A place is bare if
// the splats with centres within 1.5 spacings along the normal transmit too much in that direction.
// A new splat is a disc of half axes 0.7, 0.7 and 0.35 spacings, half a spacing above the
// particle's centre minus its own thickness, undeformed, of opacity 0.98, with the particle's
// object and label. Its colour is the mean of the object's splats within 4 spacings, weighted by
// inverse squared distance, of degree 0; without any, the object's mean. Order: barest first, then
// by particle; equal for any number of threads. Throws std::invalid_argument unless there is one
// splat per Gaussian.
RefillReport refill(CarriedSplats& splats, std::vector<Gaussian<double>>& gaussians,
                    const std::vector<Particle<double>>& particles,
                    const std::vector<double>& spacing, const RefillOptions& options,
                    const WallOptions& walls);

}  // namespace knead
