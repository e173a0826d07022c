// Depths for what is too thin to have one: where splats let more than half of what lies behind
// them through, a picture has no depth. It takes that of what is beside it, a few pixels far, and
// farther away the mean of the picture, so that a mesh can hide it or be hidden.
#pragma once
#include "cuda/splats/blend.h"

namespace knead {

constexpr int spread_rounds = 3;  // pixels far

// A pixel's depth after a round, from its own and those of its four neighbours; no_depth beyond
// the picture [m].
HD float spread_depth(float own, float left, float right, float above, float below)
{
    return own < no_depth ? own : min(min(left, right), min(above, below));
}

// Depths are added up as whole numbers, so that any order gives the same mean.
constexpr double depth_units = 0x1p20, deepest_counted = 1e5;  // in a metre; [m]
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
// The depth that is left once all rounds are over.
HD float filled_depth(float depth, bool covered, const DepthSum& sum)
{
    const bool missing = !(depth < no_depth) && covered && sum.pixels > 0;
    return missing ? mean_depth(sum) : depth;
}

}  // namespace knead
