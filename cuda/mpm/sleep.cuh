// Waking of still clay next to moving clay: in g2p it wakes if it is pushed; before the next grid
// update the blocks around it become guards.
#pragma once
#include "cuda/mpm/particle.h"
#include "cuda/mpm/stencil.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// Call if a particle moves, or must move, in block b, whose clay was still in substep n. In sleep
// mode the block moves from the next substep on.
__device__ inline void wake(const G2pView& d, int b, int n)
{
    const WakeView& r = d.rest;
    r.changed[b] = n + 1;
    if (r.options.mode != RestMode::sleep || atomicMin(&r.free[b], n + 1) != never) return;
    r.woken[n & 1][atomicAdd(&d.clock->woken[n & 1], 1)] = b;
    if (r.range[b].x < r.range[b].y) atomicAdd(&d.clock->counters[Count::woken], 1ull);
}

// Marks the block of a particle at the end of the frame's last substep n: no later substep does.
__device__ inline void note_end(const G2pView& d, const Particle<float>& q, bool ends, int n)
{
    if (ends) d.rest.changed[d.lattice.block_of(base_node(q.x, d.lattice.spacing))] = n + 1;
}

// Sleep state of a particle before its update: the block of its stencil's base; `still`: the clay
// of that block is still in this substep; `unasked`: it is not tested for waking.
struct Quiet {
    int block;
    bool still, unasked;
};
__device__ inline Quiet quiet_at(const G2pView& d, Particle<float>& q, Int3 base, int n)
{
    Quiet at{d.lattice.block_of(base), false, false};
    at.still = d.rest.free[at.block] > n;
    if (!at.still) q.hold(false);
    at.unasked = q.still() && d.rest.guard[at.block] > n;
    return at;
}

// Wakes the particle's block if the particle moves, or must move at the velocity that it has got in
// substep n of `dt` [s].
__device__ inline void wake_if_pushed(const G2pView& d, const Quiet& quiet,
                                      const Particle<float>& q, float dt, int n)
{
    const bool wakes = !q.still() || pushed(d.rest.options, q.v, dt);
    if (quiet.still && !quiet.unasked && wakes) wake(d, quiet.block, n);
}

// The neighbours of blocks woken in the substep before n become guards; the neighbours of those
// guards become at least support.
__device__ inline void guard_neighbours(const GridUpdateView& d, int n)
{
    const GuardView& r = d.rest;
    const int before = (n + 1) & 1, count = d.clock->woken[before];
    for (int w = int(blockIdx.x) - 1; w < count; w += int(gridDim.x) - 1) {
        const Int3 at = d.lattice.block_at(r.woken[before][w]);
        for (int k = int(threadIdx.x); k < 125; k += int(blockDim.x)) {
            const Int3 step = {k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2}, to = at + step;
            if (!d.lattice.stores(block_edge * to)) continue;
            const int b = d.lattice.block_of(4 * to);
            if (step.x * step.x <= 1 && step.y * step.y <= 1 && step.z * step.z <= 1)
                atomicMin(&r.guard[b], n + 1);
            if (__ldcg(&r.reached[b]) || atomicExch(&r.reached[b], 1u)) continue;
            const int2 range = r.range[b];
            for (int run = range.x / r.run; run * r.run < range.y; ++run)
                if (!atomicExch(&r.run_listed[run], 1u))
                    r.list[atomicAdd(&d.clock->listed, 1)] = run;
        }
    }
}

}  // namespace knead::gpu
