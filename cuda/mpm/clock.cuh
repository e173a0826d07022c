// Where the simulation stands, on the device.
#pragma once
#include "cuda/mpm/time_step.h"

namespace knead::gpu {

// Counted over a frame by the kernels; read by the host when it is over.
struct Counters {
    double dt_min, dt_max;  // [s]
    int substeps, limits[6];
    unsigned long long yielded, projected, clipped, confined, repaired;  // particle-substeps, nodes
    unsigned long long covered;  // particle-substeps with a blade beside them
    unsigned long long moved;    // particle-substeps; of a scene in which clay may be still
    unsigned long long woken;    // blocks
    unsigned deepest;            // bits of the largest depth found [m]
    int active_blocks;
};

// What a frame does: nothing where the one before it has stopped (stored_region.h), and what that
// one has left where it is told to go on.
enum class Mode : int { running, stopped, going_on };

// Where the simulation stands. Substeps are counted through all frames; what belongs to substep n
// is kept in place n of a ring. Nothing is written by a kernel that reads it in the same place, so
// that no thread has to wait for all others: `done` is what grid goes by and g2p writes, `begun` is
// what g2p goes by and grid writes.
struct Clock {
    int done, begun;  // substeps through; the one under way
    float dt[2];      // of the one under way and of the one after it [s]; 0: there is none
    Step steps[3];
    int active[3];               // blocks listed of substep n, in n % 3
    unsigned fastest[2];         // bits of the largest speed squared that a substep left [m^2/s^2]
    int listed, woken[2];        // where clay may be still: as RestView has them
    int near_runs, far_runs;     // lined up so far in ToolView::runs
    double duration, tool_step;  // of the frame [s]
    int side;                    // on which of their two sides the particles lie
    int sorted_from;             // on which they lay before the last sort
    double drift;                // how far a particle may have come since the last sort [m]
    bool unsorted;               // they are sorted again in this frame
    Mode mode;
    bool crowded[2];  // a block of the rim is listed, as substep n noticed, in n % 2
    Step resume;      // before which the frame has stopped
    Counters counters;
    HD Step& step(int n) { return steps[n % 3]; }
    HD const Step& step(int n) const { return steps[n % 3]; }
};

// A frame's first substep lists its blocks anew. Each later one begins with those of the one
// before, so that hardly anyone finds a block that is not listed yet: the atomic that finds out has
// high latency.
HD int listed_for(int n, bool first) { return 2 * n + first; }

// How far particles may have come when they are sorted again [cells]. Sums do not depend on the
// order, only their cost does.
constexpr double max_drift = 0.5;

}  // namespace knead::gpu
