// Events of a substep, reduced into the frame's counters.
#pragma once
#include "cuda/mpm/clock.cuh"
#include "cuda/mpm/substep.cuh"

namespace knead::gpu {

// Events of one particle.
struct Events {
    unsigned yielded, projected, confined, covered, moved;  // 0 or 1
    float depth;
};

// Events of one warp: the numbers of particles that yielded, were projected, were confined and were
// covered by a blade, one byte each; bits of the largest values.
struct Sums {
    unsigned events, deepest, fastest, stiffest;
};

template <bool tools>
__device__ Sums summed(const Events& e, float speed_squared, float stiffness)
{
    const unsigned mine =
        e.yielded + (e.projected << 8) + (e.confined << 16) + (unsigned(e.covered) << 24);
    // The bits of non-negative floats compare like their values.
    return {__reduce_add_sync(all_lanes, mine),
            tools ? __reduce_max_sync(all_lanes, __float_as_uint(e.depth)) : 0,
            __reduce_max_sync(all_lanes, __float_as_uint(speed_squared)),
            __reduce_max_sync(all_lanes, __float_as_uint(stiffness))};
}

// Barrier of the thread block; if `counts`, returns the number of threads with `counted`.
template <bool counts>
__device__ int synchronised(bool counted)
{
    if constexpr (counts) return __syncthreads_count(counted);
    __syncthreads();
    return 0;
}

// Adds the warps' events to the counters of substep n. By one thread.
template <int warps>
__device__ void report(Clock& clock, int n, const Sums (&sums)[warps], int moved)
{
    if (moved) atomicAdd(&clock.counters[Count::moved], static_cast<unsigned long long>(moved));
    Sums all{};
    UNROLL
    for (const Sums& s : sums)  // 128 particles: no byte overflows
        all = {all.events + s.events, max(all.deepest, s.deepest), max(all.fastest, s.fastest),
               max(all.stiffest, s.stiffest)};
    unsigned long long* to[] = {&clock.counters[Count::yielded], &clock.counters[Count::projected],
                                &clock.counters[Count::confined], &clock.counters[Count::covered]};
    UNROLL
    for (int k = 0; k < 4; ++k) {
        const unsigned some = all.events >> (8 * k) & 255;
        if (some) atomicAdd(to[k], static_cast<unsigned long long>(some));
    }
    if (all.deepest) atomicMax(&clock.counters.deepest, all.deepest);
    Peak& peak = clock.peaks[blockIdx.x % peak_places].of[n & 1];
    atomicMax(&peak.fastest, all.fastest);
    atomicMax(&peak.stiffest, all.stiffest);
}

}  // namespace knead::gpu
