// Simulation time, substep control and counters on the device.
#pragma once
#include <bit>

#include "cuda/math/hd.h"
#include "cuda/mpm/counts.h"
#include "cuda/mpm/lag.h"
#include "cuda/mpm/time_step.h"

namespace knead::gpu {

// Counted over a frame by the kernels; read by the host afterwards.
struct Counters {
    double dt_min, dt_max;  // [s]
    int substeps, limits[int(Limit::count)];
    Counts<unsigned long long> counts;  // `moved` with sleep only
    unsigned deepest;                   // bits of the largest depth found [m]
    unsigned touched;                   // tools that touched particles: tool_bit()
    int active_blocks;

    HD unsigned long long& operator[](Count c) { return counts[c]; }
};

// The largest values of all particles: bits of a speed squared and of a stiffness (material.h)
// [m^2/s^2 each].
struct Peak {
    unsigned fastest, stiffest;
};
// By substep, in n % 2. Each thread block updates one of several copies, to reduce contention.
struct alignas(128) Peaks {
    Peak of[2];
};
constexpr int peak_places = 4;

HD Peak largest(Peak a, Peak b) { return {max(a.fastest, b.fastest), max(a.stiffest, b.stiffest)}; }
HD Extremes extremes_of(Peak all)
{
    return {std::sqrt(double(std::bit_cast<float>(all.fastest))),
            double(std::bit_cast<float>(all.stiffest))};
}

// The element of substep n in a ring of three.
template <class T>
HD T in_ring(int n, const T (&ring)[3])
{
    const int k = n % 3;
    return k == 0 ? ring[0] : k == 1 ? ring[1] : ring[2];
}

// Number of thread blocks that pose the tools.
constexpr int pose_parts = 8;

// What a frame does. stopped: nothing, because the previous frame stopped (stored_region.h);
// going_on: the remainder of a stopped frame; cut: nothing, because the host ended the previous
// frame early; bounded: as running, and the previous frame ended early after a given number of
// substeps.
enum class Mode : int { running, stopped, going_on, cut, bounded };

// State of the time integration. Substeps are counted across frames; data of substep n is kept in
// element n of a ring of two or three. No kernel writes data that its other thread blocks read, so
// no kernel has to wait for its last thread block:
//
//      begin          a new frame: n = done
//        |
//      sort, line_up, pose, p2g         sums of substep n
//        |
//        v
//    +-> grid n       block 0: begun = n, step n + 1     g2p reads begun and dt,
//    |     |          others: velocities of n            which only grid writes
//    |     v
//    |   g2p n        sums and poses of n + 1;           grid reads done,
//    |     |          last, one thread: done = n + 1     which only g2p writes
//    |     |
//    +-----+          for as long as step n + 1 has dt > 0
//
// Access by field. r: reads, w: writes, +: many threads add, set or raise it. Others: line_up,
// pose, p2g.
//
//                   begin     sort     others     grid n                     g2p n
//    done           r         r        r          r                          w n + 1
//    first          w                             r
//    last           w                             r
//    begun          w n - 1                       r, w n                     r
//    dt[0], dt[1]                                 w n, n + 1                 r
//    steps          w n                r n        r n, w n + 1               r n + 1
//    lag            w                             r, w
//    active         r, w n: 0          + n        r n - 1, n; w n + 1: as n  + n + 1
//    peaks          r n - 1                       r n - 1; w n: 0            + n
//    crowded        r, w all: no       + n - 1    r n - 1, w it; + n
//    woken                    w all: 0            r n - 1; w n: 0            + n
//    posed          w all: -1                     r                          w n + 1
//    listed                   w, +     r          +                          r
//    near_blocks    w 0                           +
//    far_blocks     w 0                           +
//    side           r         r, w     r                                     r
//    sorted_from              w, r
//    drift          r         w 0                 +
//    unsorted       w
//    begins         w                  r
//    relisted       w                  r
//    mode, resume   r, w                          r, w: ends early before n + 1
//    halt                                         r
//    duration       w                  r          r                          r
//    tool_step      w                             r
//    counters       w 0                           +                          +
//
// Fields that grid both reads and writes in one element (crowded n - 1, drift, lag, mode, counters
// but `clipped`) are accessed only by thread 0 of block 0. `listed` grows during grid, which does
// not iterate over the list. `deform`, between grid and g2p of some substeps and after the last,
// reads done, begun, dt and lag. Between frames the host reads the clock and lets a stopped frame
// continue (host/solver/gpu/region.cu). During a frame it may set `halt`
// (host/solver/gpu/watch.cu).
//
// When which kernel may read what another one writes: substep_sync.cuh. A substep of dt 0 does
// nothing: no tools are posed for it, and g2p leaves `done` unchanged, so that the rest of the
// graph's iteration is idle.
//
// Fields that many thread blocks add to have cache lines of their own (128 bytes). p2g took 20.2 us
// with a count of runs in the same line as `side`, and 17.2 us with the two in different lines
// (H200, 137 k particles): probably its reads of `side` waited for the atomics on that line.
struct Clock {
    int done, begun;  // substeps completed; the current one
    int first;        // of the frame, or of the remainder of one
    int last;         // after which a bounded frame ends at the latest; else none of the frame's
    float dt[2];      // of the current substep and of the next [s]; 0: there is none
    Step steps[3];
    Lag lag;                        // of Gaussians, including the current substep
    int side;                       // which of the two particle arrays is current
    int sorted_from;                // which was current before the last sort
    double duration;                // of the frame [s]
    alignas(128) double tool_step;  // [s]
    double drift;                   // largest displacement since the last sort [m]
    Step resume;                    // the step at which a stopped frame resumes
    Mode mode;
    bool begins;                               // false: the frame is skipped
    bool unsorted;                             // this frame sorts the particles
    bool relisted;                             // its first substep lists blocks from the start
    bool crowded[2];                           // rim block listed, as found in substep n, in n % 2
    int halt;                                  // not 0: the host ends the frame here
    alignas(128) int active[3];                // number of blocks listed for substep n, in n % 3
    alignas(128) int posed[pose_parts];        // substep that each part is posed for, by g2p
    alignas(128) int listed, woken[2];         // with sleep only, see RestView
    alignas(128) int near_blocks, far_blocks;  // counts of order_by_contact()
    Peaks peaks[peak_places];
    alignas(128) Counters counters;
    // Of substep n, over all copies.
    HD Peak peak(int n) const
    {
        Peak all{};
        UNROLL
        for (const Peaks& p : peaks) all = largest(all, p.of[n & 1]);
        return all;
    }
    HD void set_peak(int n, Peak all)
    {
        UNROLL
        for (Peaks& p : peaks) p.of[n & 1] = {};
        peaks[0].of[n & 1] = all;
    }
    // From substep n - 1.
    HD Extremes extremes(int n) const { return extremes_of(peak(n + 1)); }
    HD Step& step(int n) { return steps[n % 3]; }
    HD const Step& step(int n) const { return steps[n % 3]; }
};

// A substep's list begins with the blocks of the previous substep, so that few blocks are new: the
// atomic that tests for new blocks has high latency. After a sort or a stopped frame, the first
// substep lists its blocks from scratch.
HD int listed_for(int n, bool relisted) { return 2 * n + relisted; }

// Contact flag of a listed block, set when the grid update lists it for the next substep: saves
// loading its mask. A scatter lists blocks without it.
constexpr int tools_near = 1 << 30, tools_far = 1 << 29;
HD int block_of(int listed) { return listed & ~(tools_near | tools_far); }
HD bool touched(int listed) { return listed & tools_near; }

// Particles are sorted again when they may have moved this far [cells]. Only the cost of sums
// depends on the order, not their value.
constexpr double max_drift = 0.5;

}  // namespace knead::gpu
