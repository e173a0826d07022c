// The length of a substep.  (22)
#pragma once
#include <cmath>

#include "cuda/math/hd.h"

namespace knead {

// Limits of a substep that do not change within a frame.
struct StepLimits {
    double courant;        // fraction of the longest stable substep [1]
    double dx, stiffness;  // spacing [m]; the stiffest material at rest [m^2/s^2], see material.h
    double viscosity;      // [s]: limit of the most viscous liquid
    double fixed;          // [s]; 0: chosen by stability
    double largest;        // [s]
};

// The state of the clay that limits a substep.
struct Extremes {
    double speed;      // of the fastest particle [m/s]
    double stiffness;  // of the stiffest particle [m^2/s^2]
};

// The largest distance that a particle moves in a substep [cells].
constexpr double max_travel = 0.5;
// Stiffening over the rest state up to which substeps are shortened: one crushed particle must not
// stall a frame. Packed snow reaches 20.
constexpr double most_stiffening = 32;

// The limit that determined a substep.
enum class Limit : int { sound, speed, tool, viscosity, fixed, frame_end, count };

struct StepChoice {
    double dt;  // [s]
    Limit limit;
};

// The longest stable substep in this state. A single particle is stable up to dx / sqrt(stiffness),
// and every other arrangement at least as far.
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

// The step to take `left` [s] before the frame's end; `tool` is the tools' limit [s]. The remaining
// time is divided evenly, so that a frame does not end with a very short substep.
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
    Limit limit;       // what determined dt
};

// The substep that starts `start` [s] into a frame.
HD Step step_at(const StepLimits& p, double start, const Extremes& clay, double tool,
                double duration)
{
    const double left = duration - start;
    if (!(left > 1e-12 * duration)) return {start, 0, Limit::frame_end};
    const StepChoice c = choose_dt(p, clay, tool, left);
    return {start, c.dt, c.limit};
}

// The substep after s, chosen during s from the state at its start, so that the scatter need not
// wait until all particles have moved. `courant` leaves room for the changes of one substep.
HD Step step_after(const Step& s, const StepLimits& p, const Extremes& clay, double tool,
                   double duration)
{
    if (!(s.dt > 0)) return s;
    return step_at(p, s.start + s.dt, clay, tool, duration);
}

}  // namespace knead
