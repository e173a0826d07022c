// How the kernels of a frame are ordered: which ones overlap, what each waits for, and what it may
// read before. All waits, signals and early starts of a substep's kernels are defined here.
//
// All kernels of a frame are on one stream. Those before its first substep run in plain order, each
// when its predecessor has ended. One substep is (brackets: only in some scenes or substeps)
//
//     grid n . [deform n] . [clear pressures n] . g2p n
//
// With programmatic dependent launch (sm_90; launch_early() below) a kernel starts when all thread
// blocks of its predecessor have *triggered* it or have ended; it then *waits* for the end of the
// predecessor (wait_upstream), and reads before this wait only what no kernel that may still run
// writes. In short:
//
//   kernel        starts after, or    triggers next    reads before its wait
//                 waits for
//   ------------  ------------------  ---------------  -----------------------------------------
//   grid, first   start: end of p2g   at its start     -
//   of a frame
//   grid n        end of g2p n - 1    after its wait   a) posed, begun, steps, lists of blocks;
//                                                      b) if posed: tools, nodes of n - 1
//   deform n      start: end of       at its start     -
//                 grid n
//   ... tools n   start: end of       at its start     -
//                 deform n
//   clear         start: end of the   at its start     -
//   pressures n   kernel before it
//   g2p n,        end of the kernel   after its wait   -
//   particles     before it
//   g2p n,        begun == n, by      at its end;      c) the clock, the frame's input
//   tools         block 0 of grid n   posed = n + 1
//
// Why this is safe. Every kernel triggers its successor only after the end of its predecessor (in
// g2p its thread blocks with particles do). So at most two kernels are resident, and all writes of
// kernels before the predecessor are visible. Then:
//
//  a) speculative_start(). g2p n - 1 writes `posed`, and appends to list n. The beginning of list n
//     (all blocks of list n - 1), the lengths of substeps and `begun` are of grid n - 1. The loads
//     bypass L1, which may hold values of an earlier substep. The start is valid if `posed` is n
//     for all parts of the tools while `begun` is n - 1, and is used if tools may touch one of the
//     thread block's first blocks of nodes. `posed` is required: with `begun` alone clay burst
//     where several programs shared the GPU (tests/solver/shared_card_test.sh). A thread block that
//     starts late may read the `begun` that block 0 of grid n has set to n: no tools are posed for
//     n + 1 then, and it waits.
//  b) near_tools(). The release of `posed` and the acquire in acquire_posed() make the tools of
//     substep n visible: g2p n - 1 has written them in the other half of a ring of two, while it
//     read those of n - 1. Nodes of n - 1 only select where contact is evaluated before the wait;
//     all others, and those that another thread block of grid n clears meanwhile, follow after it.
//     Masks are of the frame's start.
//  c) The thread blocks of g2p n that pose the tools do not wait for the end of grid n: its block 0
//     chooses the length of substep n + 1 and releases `begun` after everything that they read;
//     they acquire it. They write the tools of n + 1, the other half of a ring of two, while grid n
//     and g2p n read those of n. They cannot wait forever: g2p n starts only when all thread blocks
//     of grid n, block 0 among them, are resident or have ended.
//
// A substep of dt 0 does nothing: no tools are posed for it, so grid never starts early for it, and
// g2p leaves Clock::done as it is.
//
// Each overlap has a bit in cuda/mpm/overlap.h, and so have a) with b), and c), which need the
// early launch of their kernel to gain time. WithOverlaps in host/solver/gpu/overlaps.h selects
// which a solver uses. Without any, all launches are in plain stream order, the waits above return
// at once, and the result is the same: tests/solver/gpu_overlap_test.cpp. An overlap that gains
// less than 2 % of a substep of 137 000 particles is not used; those measured are in
// docs/engineering/dropped.md.
#pragma once
#include <cuda/atomic>

#include "cuda/device/launch.cuh"
#include "cuda/mpm/overlap.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// Launches a kernel of a substep; if `allowed` has the bit `which`, before its predecessor has
// ended. Such a kernel has to call wait_upstream() before it reads what the predecessor writes.
template <class... Parameters, class... Arguments>
void launch_early(unsigned allowed, unsigned which, const char* name, void (*kernel)(Parameters...),
                  int blocks, int threads, cudaStream_t stream, const Arguments&... arguments)
{
    if (allowed & which)
        launch_pdl(name, kernel, blocks, threads, stream, arguments...);
    else
        launch(name, kernel, blocks, threads, stream, arguments...);
}

// By every thread of a kernel of a substep other than g2p: waits for the end of the previous
// kernel, then lets the next one start.
__device__ inline void wait_for_previous_stage() { wait_upstream_and_trigger(); }

// g2p, by every thread of a thread block with particles: waits for the velocities of the substep.
__device__ inline void wait_for_velocities() { wait_upstream(); }
// By every thread of a kernel whose predecessor has ended: lets the next kernel start. g2p: once it
// is known that the substep is not empty.
__device__ inline void let_next_stage_start() { trigger_dependents(); }

// `begun`: thread block 0 of grid n has chosen the length of substep n + 1, and n is the current
// substep. Published by one thread.
__device__ inline void publish_begun(Clock& clock, int n)
{
    cuda::atomic_ref<int, cuda::thread_scope_device>(clock.begun)
        .store(n, cuda::memory_order_release);
}
// By all threads of a block.
__device__ inline void wait_for_begun(Clock& clock, int n)
{
    if (threadIdx.x == 0) {
        const cuda::atomic_ref<int, cuda::thread_scope_device> begun(clock.begun);
        while (begun.load(cuda::memory_order_acquire) != n) __nanosleep(100);
    }
    __syncthreads();
}

// `posed`: a part of the tools has its shapes for substep n. Published by all threads of a block,
// after posing.
__device__ inline void publish_posed(Clock& clock, int part, int n)
{
    __syncthreads();
    if (threadIdx.x != 0) return;
    cuda::atomic_ref<int, cuda::thread_scope_device>(clock.posed[part])
        .store(n, cuda::memory_order_release);
}
// The substep that a part is posed for; call acquire_posed() before reading the shapes.
__device__ inline int posed_for(const Clock& clock, int part)
{
    return cuda::atomic_ref<const int, cuda::thread_scope_device>(clock.posed[part])
        .load(cuda::memory_order_relaxed);
}
__device__ inline void acquire_posed()
{
    cuda::atomic_thread_fence(cuda::memory_order_acquire, cuda::thread_scope_device);
}

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

// Speculative start while the previous substep may still run: see a) above. n is -1 unless the
// tools are posed for this substep and may touch one of the first blocks, as listed for the
// previous substep. Loads bypass L1, which may hold stale values. Warp-collective.
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

}  // namespace knead::gpu
