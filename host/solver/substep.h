// Substep length, common to both back ends.  (22)
#pragma once
#include <cmath>

#include "cuda/mpm/grid.h"
#include "cuda/mpm/material.h"
#include "cuda/mpm/material_data.h"
#include "host/solver/simulator.h"

namespace knead {

// Pose of joint j at fraction `share` of a frame, in [0, 1]; the argument of centre() and posed().
template <class R>
auto joints_at(const Motion& motion, double share)
{
    return [&motion, share](int j) {
        const auto n = std::size_t(j);
        return cast<R>(between(motion.from[n], motion.to[n], share));
    };
}

// Sets activity, scale and radius factor of tool t for a frame.
template <class R>
void set_tool(Tool<R>& tool, const Motion& motion, std::size_t t)
{
    tool.active = t >= motion.active.size() || motion.active[t];
    tool.size = t < motion.size.size() ? R(motion.size[t]) : R(1);
    tool.stretch = cast<R>(motion.stretch_of(t));
}

// Mass of the lightest particle of any material [kg].
inline double lightest_particle(const SimulationConfig& s)
{
    double lightest = 1e30;
    for (const Material<double>& m : s.materials)
        if (m.mass > 0) lightest = std::fmin(lightest, m.mass);
    return lightest;
}

// Up to this mass, a clamped node counts as clipped_negligible [kg].
inline double negligible_mass(const SimulationConfig& s)
{
    return trimmed_share * lightest_particle(s);
}

// Limits of the substep that depend on the scene only; the state may lower them.  (22)
inline StepLimits step_limits(const SimulationConfig& s)
{
    StepLimits p{s.step.courant, s.lattice.dx, 0, 1e30, s.step.fixed, s.step.largest};
    for (const Material<double>& m : s.materials) {
        if (!(m.density > 0)) continue;  // removed
        p.stiffness = std::fmax(p.stiffness, stiffness(Particle<double>{}, m));
        if (m.plasticity == Plasticity::fluid && m.viscosity > 0)
            p.viscosity =
                std::fmin(p.viscosity, p.courant * p.dx * p.dx * m.density / (4 * m.viscosity));
    }
    return p;
}

// The tools' limit of dt over one frame [s]: no sphere may move by more than StepOptions::tool
// times its radius or a cell in one substep. For blades only the cell counts, because particles are
// labelled by their side. Throws std::invalid_argument if the motion lacks a joint of the rig.
double tool_step(const SimulationConfig& setup, const Motion& motion, double duration);

// Adds a substep to the statistics.
inline void count(const Step& step, FrameStats& stats)
{
    stats.dt_min = stats.substeps ? std::fmin(stats.dt_min, step.dt) : step.dt;
    stats.dt_max = std::fmax(stats.dt_max, step.dt);
    ++stats.limits[int(step.limit)];
    ++stats.substeps;
}

}  // namespace knead
