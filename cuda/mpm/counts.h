// Events counted during a frame, by kernels and CPU loops alike. host/solver/frame_stats.h has a
// row for each.
#pragma once
#include "cuda/math/hd.h"

namespace knead {

enum class Count : int {
    yielded,             // particle-substeps
    projected,           // particle-substeps in which a tool put a particle out
    clipped,             // nodes slowed to a cell per substep
    confined,            // particles put back inside the walls
    repaired,            // particles with a non-finite number
    abrupt,              // particle-substeps with dt |C| > 0.35
    moved_far,           // particle-substeps: projected by more than a cell
    clipped_negligible,  // clipped nodes of negligible mass
    covered,             // particle-substeps with a blade beside the particle
    moved,               // particle-substeps computed; < particles * substeps if clay slept
    woken,               // sleeping blocks woken by a push
    stranded,            // Gaussian-substeps without clay in reach: not moved
    splats_projected,    // Gaussian-substeps in which a tool put a Gaussian out
    splats_repaired,     // Gaussians with a non-finite number
    count
};

// One number per Count.
template <class T>
struct Counts {
    T of[int(Count::count)];

    HD T& operator[](Count c) { return of[int(c)]; }
    HD const T& operator[](Count c) const { return of[int(c)]; }
    HD void operator+=(const Counts& more)
    {
        for (int c = 0; c < int(Count::count); ++c) of[c] += more.of[c];
    }
};

template <class T, class From>
Counts<T> cast(const Counts<From>& from)
{
    Counts<T> to;
    for (int c = 0; c < int(Count::count); ++c) to.of[c] = T(from.of[c]);
    return to;
}

}  // namespace knead
