// Start of a thread block of the grid update: the current substep and its first blocks of nodes,
// determined speculatively before the previous substep has ended, or after it.
#pragma once
#include "cuda/mpm/pose.cuh"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// The index in the list of the k-th block of nodes of a thread block.
__device__ inline int place(int k) { return int(blockIdx.x) - 1 + k * (int(gridDim.x) - 1); }

// The current substep, and the first blocks of nodes of a thread block.
template <int blocks_per_cta>
struct Start {
    int n;
    float dt;                                         // [s]
    bool first;                                       // of a frame
    int count, before;                                // listed for this grid and the other
    int blocks[blocks_per_cta], old[blocks_per_cta];  // the first of each, as listed
};

// Speculative start while the previous substep may still run (clock.cuh). n is -1 unless the tools
// are posed for this substep and may touch one of the first blocks, as listed for the previous
// substep. Loads bypass L1, which may hold stale values. Warp-collective.
template <int blocks_per_cta>
__device__ Start<blocks_per_cta> speculative_start(const GridUpdateView& d)
{
    const Clock& c = *d.clock;
    const int posed = posed_for(c, int(threadIdx.x % pose_parts)), begun = __ldcg(&c.begun);
    int active[3], lists[3][blocks_per_cta];
    double dt[3];
    UNROLL
    for (int l = 0; l < 3; ++l) {
        active[l] = __ldcg(&c.active[l]), dt[l] = __ldcg(&c.steps[l].dt);
        UNROLL
        for (int k = 0; k < blocks_per_cta; ++k)
            lists[l][k] = __ldcg(&d.list[l][min(place(k), d.lattice.block_count() - 1)]);
    }
    const int n = begun + 1, before = in_ring(begun, active);
    Start<blocks_per_cta> s{n, float(in_ring(n, dt)), false, before, before, {}, {}};
    bool near = false;
    UNROLL
    for (int k = 0; k < blocks_per_cta; ++k) {
        s.old[k] = in_ring(begun, {lists[0][k], lists[1][k], lists[2][k]});
        s.blocks[k] = in_ring(n, {lists[0][k], lists[1][k], lists[2][k]});
        near = near || (place(k) < before && touched(s.blocks[k]));
    }
    if (!__all_sync(0xffffffffu, near && posed == n)) s.n = -1;
    return s;
}

// Start after the previous substep has ended. All loads that may be needed are issued together;
// values that thread block 0 writes meanwhile are not used.
template <int blocks_per_cta>
__device__ Start<blocks_per_cta> synchronized_start(const GridUpdateView& d)
{
    const Clock& c = *d.clock;
    int lists[3][blocks_per_cta];
    UNROLL
    for (int k = 0; k < blocks_per_cta; ++k) {
        const int first = min(max(place(k), 0), d.lattice.block_count() - 1);
        UNROLL
        for (int l = 0; l < 3; ++l) lists[l][k] = d.list[l][first];
    }
    const int n = c.done, active[] = {c.active[0], c.active[1], c.active[2]};
    const double dt[] = {c.steps[0].dt, c.steps[1].dt, c.steps[2].dt};
    Start<blocks_per_cta> s{
        n, float(in_ring(n, dt)), c.first == n, in_ring(n, active), in_ring(n + 2, active), {}, {}};
    UNROLL
    for (int k = 0; k < blocks_per_cta; ++k) {
        s.blocks[k] = in_ring(n, {lists[0][k], lists[1][k], lists[2][k]});
        s.old[k] = in_ring(n + 2, {lists[0][k], lists[1][k], lists[2][k]});
    }
    return s;
}

// Input of thread block 0: the current substep, and the quantities that determine the next one's
// length.
struct StepBasis {
    int n;
    Step step;
    Extremes clay;               // from the previous substep
    double tool_step, duration;  // [s]
    __device__ Step next(const StepLimits& limits) const
    {
        return step_after(step, limits, clay, tool_step, duration);
    }
};

// After the previous substep has ended. All loads are issued together.
__device__ inline StepBasis step_basis(const Clock& c)
{
    const int n = __ldcg(&c.done);
    uint4 peaks[peak_places];
    UNROLL
    for (int k = 0; k < peak_places; ++k)
        peaks[k] = __ldcg(reinterpret_cast<const uint4*>(c.peaks[k].of));
    double start[3], dt[3];
    int limit[3];
    UNROLL
    for (int k = 0; k < 3; ++k) {
        start[k] = __ldcg(&c.steps[k].start), dt[k] = __ldcg(&c.steps[k].dt);
        limit[k] = __ldcg(reinterpret_cast<const int*>(&c.steps[k].limit));
    }
    const double tool_step = __ldcg(&c.tool_step), duration = __ldcg(&c.duration);
    const Step now{in_ring(n, start), in_ring(n, dt), Limit(in_ring(n, limit))};
    Peak left{};
    UNROLL
    for (const uint4& p : peaks) left = largest(left, n & 1 ? Peak{p.x, p.y} : Peak{p.z, p.w});
    return {n, now, extremes_of(left), tool_step, duration};
}

}  // namespace knead::gpu
