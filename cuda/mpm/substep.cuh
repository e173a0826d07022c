// A thread block's part of a substep: runs of particles, one particle per thread.
#pragma once
#include "cuda/device/launch.cuh"
#include "cuda/mpm/clock.cuh"
#include "cuda/mpm/features.h"

namespace knead::gpu {

constexpr unsigned all_lanes = 0xffffffffu;

// Kept in shared memory and reloaded, to save registers while particles move.
struct SubstepContext {
    Clock* kept;
    int n, side;    // the substep to scatter for; which particle array is current
    float now, dt;  // length of the current substep and of substep n [s]; dt 0: no substep
    int run;        // of particles
    __device__ Clock& clock() const
    {
        __builtin_assume(__isGlobal(kept));
        return *kept;
    }
};

// The thread's particle of a run; past the end of the last run, the last particle.
struct Index {
    int at;
    bool valid;  // false: past the end
};
template <Features f>
__device__ Index index_in(int run, int count)
{
    const int i = run * run_length(f) + int(threadIdx.x);
    return {min(max(i, 0), count - 1), i < count};
}

// The same, rematerialised: keeping it would cost a register.
template <Features f>
__device__ Index own_index(const SubstepContext& later, int count)
{
    return index_in<f>(f.tools ? later.run : int(blockIdx.x), count);
}

// Calls visit(run) for the thread block's own run of particles; with sleep for its share of the
// listed runs. The launch's first `others` thread blocks have other tasks.
template <bool rests, class Visit>
__device__ void for_each_run(const Clock& clock, const int* listed, int others, int own,
                             Visit&& visit)
{
    if constexpr (rests) {
        __shared__ int at;  // in shared memory, to save a register
        if (threadIdx.x == 0) at = int(blockIdx.x) - others;
        __syncthreads();
        while (at < clock.listed) {
            visit(listed[at]);
            __syncthreads();  // shared memory is reused
            if (threadIdx.x == 0) at += int(gridDim.x) - others;
            __syncthreads();
        }
    } else {
        visit(own);
    }
}

// Thread blocks for all runs. With sleep few of many may be listed: no more thread blocks than keep
// the device busy, since starting idle ones takes time.
inline int blocks_for_runs(int particles, const Features& features, int multiprocessors)
{
    const int runs = blocks_for(particles, run_length(features));
    return features.rests ? min(runs, 24 * multiprocessors) : runs;
}

}  // namespace knead::gpu
