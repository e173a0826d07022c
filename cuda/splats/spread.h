// Depths for translucent pixels: where splats transmit more than half of the background, a frame
// has no depth. Such a pixel gets the depth of neighbours up to a few pixels away, or the mean
// depth of the frame if there are none, so that a mesh can hide the pixel or be hidden by it.
#pragma once
#include "cuda/splats/blend.h"

namespace knead {

constexpr int spread_rounds = 3;  // distance in pixels

// A pixel's depth after a round, from its own and its four neighbours'; no_depth outside the frame
// [m].
HD float spread_depth(float own, float left, float right, float above, float below)
{
    return own < no_depth ? own : min(min(left, right), min(above, below));
}

// Depths are summed as integers, so that the mean does not depend on the order.
constexpr double depth_units = 0x1p20, deepest_counted = 1e5;  // per metre; [m]
HD unsigned long long counted_depth(float depth)
{
    const double d = double(depth) < deepest_counted ? double(depth) : deepest_counted;
    return (unsigned long long)(d * depth_units + 0.5);
}
struct DepthSum {
    unsigned long long units, pixels;
};
HD float mean_depth(const DepthSum& sum)
{
    return float(double(sum.units) / double(sum.pixels) / depth_units);
}
// The final depth after all rounds.
HD float filled_depth(float depth, bool covered, const DepthSum& sum)
{
    const bool missing = !(depth < no_depth) && covered && sum.pixels > 0;
    return missing ? mean_depth(sum) : depth;
}

}  // namespace knead
