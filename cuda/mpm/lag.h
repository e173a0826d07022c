// When Gaussians follow the clay: not in every substep, for what they miss is told by the
// velocities of the last.  (33)
#pragma once
#include "cuda/math/hd.h"

namespace knead {

// All Gaussians follow at once, every so many substeps of a frame and in its last: between frames
// none is behind. A tool comes on by no more than half its radius a substep (22), so up to 2 none
// that was outside is past the middle of a tool when it is looked for, and leaves it in front.
constexpr int follow_every = 2;

// How far they are behind, the substep under way included; nothing when a frame begins.
struct Lag {
    int substeps;
    double time;  // [s]
    HD void add(double dt) { ++substeps, time += dt; }
    HD bool due() const { return substeps == follow_every; }
    // The length of one of these substeps [s].
    template <class R>
    HD R each() const
    {
        return R(time) / R(substeps);
    }
};

}  // namespace knead
