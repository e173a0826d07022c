// How long a substep may be, for whoever has no scene at hand: the device.  (22)
#pragma once
#include <cmath>

#include "hd.h"

namespace knead {

// What limits a substep and does not change within a frame.
struct Pace {
    double courant;    // share of a cell a wave or a particle may cross [1]
    double dx, sound;  // spacing [m], fastest wave of all materials [m/s]
    double viscosity;  // [s]: limit of the most viscous liquid
    double fixed;      // [s]; 0: as stability asks
    double largest;    // [s]
};

// Numbered as Limit in host/solver.h.
enum PaceLimit : int { by_sound, by_speed, by_tool, by_viscosity, by_fixed, by_frame_end };

struct PaceChoice {
    double dt;  // [s]
    int limit;
};

// For clay moving at up to `speed` [m/s], `left` [s] before the frame's end; `tool` is the tools'
// limit [s]. What remains is shared out evenly, so that no frame ends on a sliver.
HD PaceChoice paced(const Pace& p, double speed, double tool, double left)
{
    PaceChoice best{p.largest, by_speed};
    const auto at_most = [&](double dt, int limit) {
        if (dt < best.dt) best = {dt, limit};
    };
    if (p.fixed > 0) {
        best = {p.fixed, by_fixed};
    } else {
        at_most(p.viscosity, by_viscosity);
        at_most(p.courant * p.dx / (p.sound + speed), p.sound > speed ? by_sound : by_speed);
        at_most(tool, by_tool);
    }
    if (best.dt >= left) return {left, by_frame_end};
    if (p.fixed > 0) return best;
    return {left / std::ceil(left / best.dt * (1 - 1e-9)), best.limit};
}

}  // namespace knead
