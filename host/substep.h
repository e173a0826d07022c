// What both backends agree on: how long a substep may be.  (22)
#pragma once
#include "cuda/material.h"
#include "solver.h"

namespace knead {

struct StepChoice {
    double dt;
    Limit limit;
};

// The longest stable substep [s] for clay moving at up to `speed` [m/s] of which `left` [s] of the
// frame remain; `tool_dt` is the tools' limit [s]. What remains is shared out evenly, so that no
// frame ends on a sliver.
inline StepChoice step_length(const Setup& setup, double speed, double tool_dt, double left)
{
    const double dx = setup.lattice.dx;
    StepChoice best{setup.step.largest, Limit::speed};
    const auto at_most = [&](double dt, Limit limit) {
        if (dt < best.dt) best = {dt, limit};
    };
    if (setup.step.fixed > 0) {
        best = {setup.step.fixed, Limit::fixed};
    } else {
        double fastest = 0;
        for (const Material<double>& m : setup.materials) {
            const double stiff = m.flow == Flow::clamp ? std::sqrt(packed(m, -0.1)) : 1.0;
            fastest = std::fmax(fastest, stiff * sound_speed(m));
            if (m.flow == Flow::fluid && m.viscosity > 0)
                at_most(dx * dx * m.density / (6 * m.viscosity), Limit::viscosity);
        }
        at_most(setup.step.courant * dx / (fastest + speed),
                fastest > speed ? Limit::sound : Limit::speed);
        at_most(tool_dt, Limit::tool);
    }
    if (best.dt >= left) return {left, Limit::frame_end};
    const double steps = std::ceil(left / best.dt * (1 - 1e-9));
    if (setup.step.fixed > 0) return best;
    return {left / steps, best.limit};
}

// The tools' limit on a substep over one frame [s]: none may cross more than `share` of its own
// radius, or of a cell, at once. A blade's thickness does not count: its sides know the particles.
double tool_step(const Setup& setup, const Motion& motion, double duration);

}  // namespace knead
