// What both backends agree on: how long a substep may be.  (22)
#pragma once
#include <cmath>

#include "cuda/mpm/grid.h"
#include "cuda/mpm/material.h"
#include "cuda/mpm/material_data.h"
#include "host/solver/solver.h"

namespace knead {

// Joint j at the share of a frame, in [0, 1]: what centre() and posed() ask for.
template <class R>
auto joints_at(const Motion& motion, double share)
{
    return [&motion, share](int j) {
        const auto n = std::size_t(j);
        return cast<R>(between(motion.from[n], motion.to[n], share));
    };
}

// Whether tool t acts in a frame, how large it is, and the share of its radii that it has.
template <class R>
void set_tool(Tool<R>& tool, const Motion& motion, std::size_t t)
{
    tool.active = t >= motion.active.size() || motion.active[t];
    tool.size = t < motion.size.size() ? R(motion.size[t]) : R(1);
    tool.stretch = cast<R>(motion.stretch_of(t));
}

// The mass of the lightest particle that there may be [kg].
inline double lightest_particle(const Setup& s)
{
    double lightest = 1e30;
    for (const Material<double>& m : s.materials)
        if (m.mass > 0) lightest = std::fmin(lightest, m.mass);
    return lightest;
}

// What a node holds that is trimmed, not clipped, where it is slowed: at most [kg].
inline double negligible_mass(const Setup& s) { return trimmed_share * lightest_particle(s); }

// What of a scene limits its substeps; its state may limit them further.  (22)
inline StepLimits step_limits(const Setup& s)
{
    StepLimits p{s.step.courant, s.lattice.dx, 0, 1e30, s.step.fixed, s.step.largest};
    for (const Material<double>& m : s.materials) {
        if (!(m.density > 0)) continue;  // was removed
        p.stiffness = std::fmax(p.stiffness, stiffness(Particle<double>{}, m));
        if (m.plasticity == Plasticity::fluid && m.viscosity > 0)
            p.viscosity =
                std::fmin(p.viscosity, p.courant * p.dx * p.dx * m.density / (4 * m.viscosity));
    }
    return p;
}

// The tools' limit on a substep over one frame [s]: none may cross more than `share` of its own
// radius, or of a cell, at once. A blade's thickness does not count: its sides know the particles.
// Throws std::invalid_argument where the motion lacks a joint that the rig hangs on.
double tool_step(const Setup& setup, const Motion& motion, double duration);

// Counts a substep.
inline void count(const Step& step, FrameStats& stats)
{
    stats.dt_min = stats.substeps ? std::fmin(stats.dt_min, step.dt) : step.dt;
    stats.dt_max = std::fmax(stats.dt_max, step.dt);
    ++stats.limits[int(step.limit)];
    ++stats.substeps;
}

}  // namespace knead
