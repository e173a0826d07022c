// Where the simulation stands, on the device.
#pragma once
#include <bit>

#include "cuda/math/hd.h"
#include "cuda/mpm/lag.h"
#include "cuda/mpm/time_step.h"

namespace knead::gpu {

// Counted over a frame by the kernels; read by the host when it is over.
struct Counters {
    double dt_min, dt_max;  // [s]
    int substeps, limits[6];
    unsigned long long yielded, projected, clipped, confined, repaired;  // particle-substeps, nodes
    unsigned long long abrupt, moved_far, clipped_negligible;  // particle-substeps, likewise, nodes
    unsigned long long covered;  // particle-substeps with a blade beside them
    unsigned long long moved;    // particle-substeps; of a scene in which clay may be still
    unsigned long long woken;    // blocks
    unsigned long long stranded, splats_projected, splats_repaired;  // Gaussian-substeps
    unsigned deepest;  // bits of the largest depth found [m]
    unsigned touched;  // tools that touched particles: tool_bit()
    int active_blocks;
};

// The largest of what particles have: bits of a speed squared and of a stiffness (material.h)
// [m^2/s^2 each].
struct Peak {
    unsigned fastest, stiffest;
};
// By substep, in n % 2. Each thread block raises one of several, so that fewer meet at one place.
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

// Of a ring of three, the place of substep n.
template <class T>
HD T in_ring(int n, const T (&ring)[3])
{
    const int k = n % 3;
    return k == 0 ? ring[0] : k == 1 ? ring[1] : ring[2];
}

// Posing is shared by so many thread blocks.
constexpr int pose_parts = 8;

// What a frame does: nothing where the one before it has stopped (stored_region.h), and what that
// one has left where it is told to go on; nothing where that one was cut, as the host asked.
enum class Mode : int { running, stopped, going_on, cut };

// Where the simulation stands. Substeps are counted through all frames; what belongs to substep n
// is kept in place n of a ring, of two or of three. No kernel writes what other blocks of it read,
// so that none waits for its last block:
//
//      begin          a new frame: n = done
//        |
//      sort, line_up, pose, p2g         sums of substep n
//        |
//        v
//    +-> grid n       block 0: begun = n, step n + 1     g2p goes by begun and dt,
//    |     |          others: velocities of n            which only grid writes
//    |     v
//    |   g2p n        sums and poses of n + 1;           grid goes by done,
//    |     |          last, one thread: done = n + 1     which only g2p writes
//    |     |
//    +-----+          for as long as step n + 1 has dt > 0
//
// Place by place, r: reads, w: writes, +: many threads add, or set or raise it. Others: line_up,
// pose, p2g.
//
//                   begin     sort     others     grid n                     g2p n
//    done           r         r        r          r                          w n + 1
//    first          w                             r
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
//    unsorted_side  w                  r
//    drift          r         w 0                 +
//    unsorted       w
//    begins         w                  r
//    relisted       w                  r
//    mode, resume   r, w                          r, w: stopped or cut before n + 1
//    halt                                         r
//    duration       w                  r          r                          r
//    tool_step      w                             r
//    counters       w 0                           +                          +
//
// What grid both reads and writes in one place (crowded n - 1, drift, lag, mode, counters but
// `clipped`) only thread 0 of block 0 touches. `listed` grows under grid, which does not go through
// the list. `deform`, between grid and g2p of some substeps and after the last, reads done, begun,
// dt and lag. Between frames the host reads the clock, and where one has stopped, says that it goes
// on (host/solver/gpu/region.cu). While one is under way it may set `halt`
// (host/solver/gpu/watch.cu).
//
// A frame's first grid is launched when all that comes before it is over. From then on grid and g2p
// start early (launch_pdl): each waits for the end of the kernel before it and only then lets the
// next one take its places, so no more than two of them are on the device, and what the last but
// one has written is there. Before it waits, g2p n reads `side`, its run and where its particles
// are, which g2p n - 1 has written. Its thread blocks that pose do not wait for the end of grid n
// at all, but for `begun` to become n (acquire): block 0 of grid n writes it last of what they read
// (release). grid n starts when all thread blocks of g2p n - 1 have; those that pose write `posed`
// n when they have (release), and only then let it start. Where grid n finds that (acquire) and
// `begun` still n - 1, it knows before it waits which substep is its own, how long it is, and that
// its list begins with all of that of n - 1: so it looks for contact at nodes of its first block
// while g2p n - 1 still runs. `posed` has to say so: going by `begun` alone clay burst where
// programs shared the card. A substep of dt 0 does nothing: nobody poses for it, and g2p leaves
// `done` as it is, so that the rest of a turn of the graph runs idle.
//
// What many thread blocks add to lies in lines of memory of its own (128 bytes). With a count of
// runs in the line of `side` p2g took 20.2 us, apart from it 17.2 (H200, 137 k particles): probably
// its reads of `side` waited behind the atomics on that line.
struct Clock {
    int done, begun;  // substeps through; the one under way
    int first;        // of the frame, or of what is left of one
    float dt[2];      // of the one under way and of the one after it [s]; 0: there is none
    Step steps[3];
    Lag lag;                        // of Gaussians, with the substep under way
    int side;                       // on which of their two sides the particles lie
    int sorted_from;                // on which they lay before the last sort
    double duration;                // of the frame [s]
    alignas(128) double tool_step;  // [s]
    double drift;                   // how far a particle may have come since the last sort [m]
    Step resume;                    // before which the frame has stopped
    Mode mode;
    bool begins;                         // the frame does, or goes on; else it does nothing
    bool unsorted;                       // they are sorted again in this frame
    bool relisted;                       // its first substep lists blocks from the start
    int unsorted_side;                   // on which the particles lay when it began
    bool crowded[2];                     // a block of the rim is listed, as n noticed, in n % 2
    int halt;                            // not 0: the host asks that the frame end here
    alignas(128) int active[3];          // blocks listed of substep n, in n % 3
    alignas(128) int posed[pose_parts];  // what each part of the tools has been posed for, by g2p
    alignas(128) int listed, woken[2];   // where clay may be still: as RestView has them
    alignas(128) int near_blocks, far_blocks;  // lined up so far, in a frame's second list
    Peaks peaks[peak_places];
    alignas(128) Counters counters;
    // Of all that substep n left.
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
    // What the substep before n left.
    HD Extremes extremes(int n) const { return extremes_of(peak(n + 1)); }
    HD Step& step(int n) { return steps[n % 3]; }
    HD const Step& step(int n) const { return steps[n % 3]; }
};

// A substep's list of blocks begins with those of the one before, so that blocks are rarely found
// not to be listed yet: the atomic that finds out has high latency. Where particles are sorted, and
// after a frame that had to stop, a frame's first substep lists its blocks from the start.
HD int listed_for(int n, bool relisted) { return 2 * n + relisted; }

// How the grid update lists a block for the next substep: with a note whether tools may touch it,
// which spares loading its mask. A scatter lists it without.
constexpr int tools_near = 1 << 30, tools_far = 1 << 29;
HD int block_of(int listed) { return listed & ~(tools_near | tools_far); }
HD bool touched(int listed) { return listed & tools_near; }

// How far particles may have come when they are sorted again [cells]. Sums do not depend on the
// order, only their cost does.
constexpr double max_drift = 0.5;

}  // namespace knead::gpu
