// When Gaussians follow the clay: not in every substep, for what they miss is told by the
// velocities of the last.  (33)
#pragma once
#include "cuda/math/hd.h"

namespace knead {

// All Gaussians follow at once, every so many substeps of a frame and in its last: between frames
// none is behind.
constexpr int follow_every = 2;

// Out of tools they go in a frame's last substep; and each time that they follow, where a tool
// comes on in the frame by more than its radius or a cell (half of which, the lesser, it comes on
// by in tool_step [s], and in no substep by more (22)), or where one cuts. So none that was outside
// is past the middle of a tool when it is looked for, and it leaves in front.
HD bool clears_each_time(bool blades, double duration, double tool_step)
{
    return blades || duration > 2 * tool_step;
}

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
