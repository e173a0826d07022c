// How long a substep may be.  (22)
#pragma once
#include <cmath>

#include "cuda/math/hd.h"

namespace knead {

// What limits a substep and does not change within a frame.
struct StepLimits {
    double courant;    // share of a cell a wave or a particle may cross [1]
    double dx, sound;  // spacing [m], fastest wave of all materials [m/s]
    double viscosity;  // [s]: limit of the most viscous liquid
    double fixed;      // [s]; 0: as stability asks
    double largest;    // [s]
};

// What cut a substep.
enum class Limit : int { sound, speed, tool, viscosity, fixed, frame_end, count };

struct StepChoice {
    double dt;  // [s]
    Limit limit;
};

// For clay moving at up to `speed` [m/s], `left` [s] before the frame's end; `tool` is the tools'
// limit [s]. What remains is shared out evenly, so that no frame ends on a sliver.
HD StepChoice choose_dt(const StepLimits& p, double speed, double tool, double left)
{
    StepChoice best{p.largest, Limit::speed};
    const auto at_most = [&](double dt, Limit limit) {
        if (dt < best.dt) best = {dt, limit};
    };
    if (p.fixed > 0) {
        best = {p.fixed, Limit::fixed};
    } else {
        at_most(p.viscosity, Limit::viscosity);
        at_most(p.courant * p.dx / (p.sound + speed),
                p.sound > speed ? Limit::sound : Limit::speed);
        at_most(tool, Limit::tool);
    }
    if (best.dt >= left) return {left, Limit::frame_end};
    if (p.fixed > 0) return best;
    return {left / std::ceil(left / best.dt * (1 - 1e-9)), best.limit};
}

// One substep of a frame.
struct Step {
    double start, dt;  // [s] from the frame's beginning; dt 0: there is none
    Limit limit;       // what cut it
};

// The substep that begins `start` into a frame, for clay moving at up to `speed` [m/s].
HD Step step_at(const StepLimits& p, double start, double speed, double tool, double duration)
{
    const double left = duration - start;
    if (!(left > 1e-12 * duration)) return {start, 0, Limit::frame_end};
    const StepChoice c = choose_dt(p, speed, tool, left);
    return {start, c.dt, c.limit};
}

// The one after it, chosen before it is through, from the speeds at its beginning: the scatter for
// a substep need not wait until all particles have moved. That one substep's change of speed is
// what the Courant number leaves room for.
HD Step step_after(const Step& s, const StepLimits& p, double speed, double tool, double duration)
{
    if (!(s.dt > 0)) return s;
    return step_at(p, s.start + s.dt, speed, tool, duration);
}

}  // namespace knead
