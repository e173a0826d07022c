// Splits splats that the clay has stretched too far into two, which then move independently.
#pragma once
#include <vector>

#include "host/splats/carried.h"

namespace knead {

struct SplitOptions {
    double limit = 1.6;         // longest half axis / that at rest, above which a splat is split
    double smallest = 0;        // smaller half axes are not split [m]
    std::size_t budget = 2000;  // splats per call, most stretched first
    std::size_t capacity = ~std::size_t(0);  // total splats
};

struct SplitReport {
    std::vector<GaussianSplit> splits;  // splats that were split
    std::size_t waiting = 0;  // beyond the limit, but not split for lack of budget or capacity
};

// Variance of each half of a pair along the split axis, relative to the original. The remainder is
// the variance of the centres.
constexpr double pair_variance = 0.5;

// Optical depth of a splat, -ln(1 - alpha), integrated over the screen and divided by 2 pi times
// the product of its half axes there: the dilogarithm of its opacity, 0 to 1.
double summed_depth(double opacity);
// Opacity of each half of a pair that occludes as much as one splat of this opacity: transmittance
// through many splats depends on the sum of their optical depths.
double pair_opacity(double opacity);

// Splits every splat whose longest deformed half axis is more than `limit` times its extent at
// rest, along that axis. Conserved exactly: the sums over the pair of the Gaussians' mass, mean,
// covariance and optical depth, and colour, object, label, total deformation. The second of each
// pair is appended at the end; both keep the extent, so that further stretching splits again.
// Centres stay between the walls. Order: most stretched first, then by index; equal for any number
// of threads. Throws std::invalid_argument unless there is one splat per Gaussian.
SplitReport split(CarriedSplats& splats, std::vector<Gaussian<double>>& gaussians,
                  const SplitOptions& options, const WallOptions& walls);

}  // namespace knead
