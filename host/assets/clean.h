// Which splats of a cloud belong to the object: faint, far, huge and isolated ones are left out.
#pragma once
#include <cstdint>

#include "host/files/splat_file.h"

namespace knead {

struct CleanOptions {
    double min_opacity = 0.02;
    double max_size = 20;  // longest half axis over the median one
    double isolation = 5;  // distance to the `neighbours`-th neighbour over the median one
    int neighbours = 6;
};

// How many were left out; each is counted once, by the first that holds.
struct CleanReport {
    std::size_t not_finite = 0;  // a number that is not finite
    std::size_t faint = 0;       // opacity below min_opacity
    std::size_t far = 0;         // more than the object's size away from it, on some axis
    std::size_t huge = 0;        // larger than max_size and a twentieth of the object
    std::size_t isolated = 0;

    std::size_t dropped() const { return not_finite + faint + far + huge + isolated; }
};

struct CleanCloud {
    std::vector<std::uint32_t> kept;  // indices, rising
    CleanReport report;
};

// The object's size is that of the box between the 2nd and 98th percentile of the centres along
// each axis, three median half axes added. Time: the number of splats times 1000 for the median
// distance, over a sample; memory 40 bytes a splat. Nothing may be kept.
CleanCloud clean(const SplatCloud& cloud, const CleanOptions& options);

}  // namespace knead
