// Selects the splats of a cloud that belong to the object: faint, far, huge and isolated ones are
// dropped.
#pragma once
#include <cstdint>

#include "host/files/splat_file.h"

namespace knead {

struct CleanOptions {
    double min_opacity = 0.02;
    double max_size = 20;  // longest half axis / the median one
    double isolation = 5;  // distance to the `neighbours`-th neighbour / the median one
    int neighbours = 6;
};

// Numbers of dropped splats, each counted once, by the first criterion that applies.
struct CleanReport {
    std::size_t not_finite = 0;  // a number that is not finite
    std::size_t faint = 0;       // opacity below min_opacity
    std::size_t far = 0;         // farther from the object than its size, on some axis
    std::size_t huge = 0;        // larger than max_size and than a twentieth of the object
    std::size_t isolated = 0;

    std::size_t dropped() const { return not_finite + faint + far + huge + isolated; }
};

struct CleanCloud {
    std::vector<std::uint32_t> kept;  // indices, ascending
    CleanReport report;
};

// The object's size is the size of the box between the 2nd and 98th percentile of the centres along
// each axis, enlarged by three median half axes. Time: 1000 times the number of splats, for the
// median distance over a sample; memory: 40 bytes per splat. The result may be empty.
CleanCloud clean(const SplatCloud& cloud, const CleanOptions& options);

}  // namespace knead
