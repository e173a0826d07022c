// Splats that clay has drawn out too far become two each, which then go different ways.
#pragma once
#include <vector>

#include "host/splats/carried.h"

namespace knead {

struct SplitOptions {
    double limit = 1.6;         // longest half axis over that at rest: beyond it a splat is split
    double smallest = 0;        // half axes up to this are left as they are [m]
    std::size_t budget = 2000;  // splats a call, those farthest beyond the limit first
    std::size_t capacity = ~std::size_t(0);  // splats in all
};

struct SplitReport {
    std::vector<GaussianSplit> splits;  // those that are two now
    std::size_t waiting = 0;  // beyond the limit, but also beyond the budget or the capacity
};

// Of a pair, the variance along the axis that was split, over that of the whole. The centres' own
// variance is the rest.
constexpr double pair_variance = 0.5;

// A splat's optical depth, -ln(1 - alpha), summed over the screen, over 2 pi times the product of
// its half axes there: the dilogarithm of its opacity, 0 to 1.
double summed_depth(double opacity);
// The opacity of each of a pair that hides as much as one splat of this opacity: the light that
// passes many splats is told by the sum of their optical depths.
double pair_opacity(double opacity);

// Splits every splat whose longest half axis, deformed, is more than `limit` times its extent at
// rest, along that axis. What is kept exactly: the sums over the pair of the Gaussians' mass, mean
// and covariance, optical depth, colour, object, label, total deformation. The second of each pair
// comes behind all others; both keep the extent, so that what is drawn out further is split again.
// Centres stay between the walls. In the order of how far they are beyond the limit, then of their
// index: the same for any number of threads. Throws std::invalid_argument where the splats are not
// the Gaussians', one for each.
SplitReport split(CarriedSplats& splats, std::vector<Gaussian<double>>& gaussians,
                  const SplitOptions& options, const WallOptions& walls);

}  // namespace knead
