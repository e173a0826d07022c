// How long a substep may be.  (22)
#pragma once
#include <cmath>

#include "cuda/math/hd.h"

namespace knead {

// What limits a substep and does not change within a frame.
struct StepLimits {
    double courant;        // share of the longest substep that is stable [1]
    double dx, stiffness;  // spacing [m]; the stiffest material at rest [m^2/s^2], see material.h
    double viscosity;      // [s]: limit of the most viscous liquid
    double fixed;          // [s]; 0: as stability asks
    double largest;        // [s]
};

// The state of the clay that limits a substep.
struct Extremes {
    double speed;      // of the fastest particle [m/s]
    double stiffness;  // of the stiffest [m^2/s^2]
};

// What a particle crosses in a substep at most [cells].
constexpr double max_travel = 0.5;
// So many times as stiff as at rest clay may become before substeps grow no shorter: one crushed
// particle must not hold up a frame for ever. Packed snow reaches 20.
constexpr double most_stiffening = 32;

// What cut a substep.
enum class Limit : int { sound, speed, tool, viscosity, fixed, frame_end, count };

struct StepChoice {
    double dt;  // [s]
    Limit limit;
};

// The longest for clay in this state. A lone particle is stable up to dx / sqrt(stiffness), and no
// other arrangement is less so.
HD StepChoice longest_dt(const StepLimits& p, const Extremes& clay)
{
    if (p.fixed > 0) return {p.fixed, Limit::fixed};
    StepChoice best{p.largest, Limit::speed};
    const auto at_most = [&](double dt, Limit limit) {
        if (dt < best.dt) best = {dt, limit};
    };
    at_most(p.viscosity, Limit::viscosity);
    const double most = most_stiffening * p.stiffness;
    double stiffness = p.stiffness;
    if (clay.stiffness > stiffness) stiffness = clay.stiffness < most ? clay.stiffness : most;
    if (stiffness > 0) at_most(p.courant * p.dx / std::sqrt(stiffness), Limit::sound);
    if (clay.speed > 0) at_most(max_travel * p.dx / clay.speed, Limit::speed);
    return best;
}

// The one to take `left` [s] before the frame's end; `tool` is the tools' limit [s]. What remains
// is shared out evenly, so that no frame ends on a sliver.
HD StepChoice choose_dt(const StepLimits& p, const Extremes& clay, double tool, double left)
{
    StepChoice best = longest_dt(p, clay);
    if (!(p.fixed > 0) && tool < best.dt) best = {tool, Limit::tool};
    if (best.dt >= left) return {left, Limit::frame_end};
    if (p.fixed > 0) return best;
    return {left / std::ceil(left / best.dt * (1 - 1e-9)), best.limit};
}

// One substep of a frame.
struct Step {
    double start, dt;  // [s] from the frame's beginning; dt 0: there is none
    Limit limit;       // what cut it
};

// The substep that begins `start` into a frame.
HD Step step_at(const StepLimits& p, double start, const Extremes& clay, double tool,
                double duration)
{
    const double left = duration - start;
    if (!(left > 1e-12 * duration)) return {start, 0, Limit::frame_end};
    const StepChoice c = choose_dt(p, clay, tool, left);
    return {start, c.dt, c.limit};
}

// The one after it, chosen before it is through, from the state at its beginning: the scatter for
// a substep need not wait until all particles have moved. What one substep changes is what the
// share `courant` leaves room for.
HD Step step_after(const Step& s, const StepLimits& p, const Extremes& clay, double tool,
                   double duration)
{
    if (!(s.dt > 0)) return s;
    return step_at(p, s.start + s.dt, clay, tool, duration);
}

}  // namespace knead
