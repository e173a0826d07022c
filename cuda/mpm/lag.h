// When Gaussians are advected with the clay: not in every substep; the last substep's velocities
// account for those skipped.  (33)
#pragma once
#include "cuda/math/hd.h"

namespace knead {

// All Gaussians are advected together, every `follow_every` substeps and in a frame's last one, so
// that none lags between frames.
constexpr int follow_every = 2;

// Gaussians are moved out of tools in a frame's last substep; and at every advection if a tool
// moves in the frame by more than its radius or a cell, or if one is a blade. (In tool_step [s] a
// tool moves by half the lesser of its radius and a cell, and no substep is longer (22).) So a
// Gaussian that was outside has not passed the middle of a tool when it is tested, and is moved out
// in front of the tool.
HD bool clears_each_time(bool blades, double duration, double tool_step)
{
    return blades || duration > 2 * tool_step;
}

// Time since the last advection, including the current substep; zero at the start of a frame.
struct Lag {
    int substeps;
    double time;  // [s]
    HD void add(double dt) { ++substeps, time += dt; }
    HD bool due() const { return substeps == follow_every; }
    // The mean length of these substeps [s].
    template <class R>
    HD R each() const
    {
        return R(time) / R(substeps);
    }
};

}  // namespace knead
