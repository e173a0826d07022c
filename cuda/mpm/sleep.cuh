// Clay that lies still while its neighbours move: in g2p it may be pushed, and wakes; before the
// next grid update the blocks around it become guards.
#pragma once
#include "cuda/mpm/particle.h"
#include "cuda/mpm/stencil.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// A particle moves in block b, or will, whose clay was still in substep n: where clay may wake, the
// block's moves from the next substep on.
__device__ inline void wake(const G2pView& d, int b, int n)
{
    const WakeView& r = d.rest;
    r.changed[b] = n + 1;
    if (r.options.mode != RestMode::sleep || atomicMin(&r.free[b], n + 1) != never) return;
    r.woken[n & 1][atomicAdd(&d.clock->woken[n & 1], 1)] = b;
    if (r.range[b].x < r.range[b].y) atomicAdd(&d.clock->counters.woken, 1ull);
}

// Where a particle has come to in the frame's last substep n: none after it checks.
__device__ inline void note_end(const G2pView& d, const Particle<float>& q, bool ends, int n)
{
    if (ends) d.rest.changed[d.lattice.block_of(base_node(q.x, d.lattice.spacing))] = n + 1;
}

// What is known of a particle where clay may be still, before it is looked at: the block of its
// stencil's base, whether that block's clay is still in this substep, whether no check is made.
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

// Wakes the particle's block where, with the velocity that has come to it in substep n of `dt` [s],
// it moves or must move.
__device__ inline void wake_if_pushed(const G2pView& d, const Quiet& quiet,
                                      const Particle<float>& q, float dt, int n)
{
    const bool wakes = !q.still() || pushed(d.rest.options, q.v, dt);
    if (quiet.still && !quiet.unasked && wakes) wake(d, quiet.block, n);
}

// What the substep before n woke: the neighbours become guards, theirs at least support.
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
