// A thread block's share of a substep: runs of particles, one of them a thread's.
#pragma once
#include "cuda/device/launch.cuh"
#include "cuda/mpm/clock.cuh"
#include "cuda/mpm/features.h"

namespace knead::gpu {

constexpr unsigned all_lanes = 0xffffffffu;

// What a thread block reads again later rather than keep it in registers while particles move.
struct SubstepContext {
    Clock* kept;
    int n, side;    // the substep that is scattered for; which particle array is current
    float now, dt;  // of the substep under way and of that one [s]; dt 0: there is none
    int run;        // of particles
    __device__ Clock& clock() const
    {
        __builtin_assume(__isGlobal(kept));
        return *kept;
    }
};

// The thread's particle of a run; of the last run's end the last one again and again.
struct Index {
    int at;
    bool valid;  // false: again
};
template <Features f>
__device__ Index index_in(int run, int count)
{
    const int i = run * run_length(f) + int(threadIdx.x);
    return {min(max(i, 0), count - 1), i < count};
}

// The same, rematerialised: to keep it would cost a register.
template <Features f>
__device__ Index own_index(const SubstepContext& later, int count)
{
    return index_in<f>(f.tools ? later.run : int(blockIdx.x), count);
}

// Calls visit(run) for the thread block's own run of particles, or where clay may be still for as
// many of the listed ones as fall to it. The launch's first `others` blocks do other things.
template <bool rests, class Visit>
__device__ void for_each_run(const Clock& clock, const int* listed, int others, int own,
                             Visit&& visit)
{
    if constexpr (rests) {
        __shared__ int at;  // kept here, not in registers
        if (threadIdx.x == 0) at = int(blockIdx.x) - others;
        __syncthreads();
        while (at < clock.listed) {
            visit(listed[at]);
            __syncthreads();  // shared memory is used again
            if (threadIdx.x == 0) at += int(gridDim.x) - others;
            __syncthreads();
        }
    } else {
        visit(own);
    }
}

// Thread blocks for all runs. Where few of many may be listed, no more than keep the device busy:
// starting one for nothing takes time, too.
inline int blocks_for_runs(int particles, const Features& features, int multiprocessors)
{
    const int runs = blocks_for(particles, run_length(features));
    return features.rests ? min(runs, 24 * multiprocessors) : runs;
}

}  // namespace knead::gpu
