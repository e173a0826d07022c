// Before a frame's first substep: the activity of each block of nodes.
#include "cuda/device/launch.cuh"
#include "cuda/device/ordered.cuh"
#include "cuda/mpm/sleep.h"
#include "cuda/mpm/stages.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

// Bounding boxes of the tools over the whole frame; empty for inactive tools.
struct Boxes {
    int low[3][max_boxes], high[3][max_boxes];
    __device__ Box3<float> at(int t) const
    {
        return {{unordered(low[0][t]), unordered(low[1][t]), unordered(low[2][t])},
                {unordered(high[0][t]), unordered(high[1][t]), unordered(high[2][t])}};
    }
};

// By all threads of a block.
__device__ void find_boxes(const SweptView& t, float reach, Boxes& boxes)
{
    for (int k = int(threadIdx.x); k < 3 * max_boxes; k += threads)
        boxes.low[0][k] = ordered(1e30f), boxes.high[0][k] = ordered(-1e30f);
    __syncthreads();
    for (int i = int(threadIdx.x); i < t.primitives.count; i += threads) {
        const int tool = t.primitives[i].tool;
        if (!t.tools[tool].active) continue;
        const Shape<float>& s = t.mid_frame[i];
        const float margin = t.travel[i] + reach;
        const auto grow = [&](int axis, float low, float high) {
            atomicMin(&boxes.low[axis][tool], ordered(low - margin));
            atomicMax(&boxes.high[axis][tool], ordered(high + margin));
        };
        grow(0, s.low.x, s.high.x), grow(1, s.low.y, s.high.y), grow(2, s.low.z, s.high.z);
    }
    __syncthreads();
}

__global__ void __launch_bounds__(threads)
    activity_kernel(const __grid_constant__ ActivityView d, int runs)
{
    __shared__ Boxes boxes;
    find_boxes(d, d.options.reach, boxes);
    const int first = int(blockIdx.x * threads + threadIdx.x);
    for (int run = first; run < runs; run += int(gridDim.x) * threads) d.run_listed[run] = 0;
    if (first == 0) d.clock->listed = d.clock->woken[0] = d.clock->woken[1] = 0;
    if (first >= d.lattice.block_count()) return;
    const int b = first;
    d.quiet[b] = rested(d.options, d.quiet[b], __uint_as_float(d.fastest[b]));
    d.fastest[b] = 0;
    d.range[b] = {0, 0};
    bool near = false;
    if (d.primitives.count > 0)
        for (int t = 0; t < d.tools.count; ++t)
            near = near || meets(boxes.at(t), d.lattice.block_at(b), block_edge * d.lattice.dx);
    d.activity[b] = own_activity(d.options, d.quiet[b], near);
}

// Raises the neighbours of each block at `activity`.
__global__ void __launch_bounds__(threads)
    spread_kernel(const __grid_constant__ SpreadView d, int activity)
{
    const int b = int(blockIdx.x * threads + threadIdx.x);
    if (b >= d.lattice.block_count() || d.activity[b] != activity) return;
    const int min_of_them = neighbour_of(d.options, activity);
    const Int3 at = d.lattice.block_at(b);
    const Int3 first = d.lattice.first_block, end = d.lattice.end_block();
    for (int z = max(at.z - 1, first.z); z < min(at.z + 2, end.z); ++z)
        for (int y = max(at.y - 1, first.y); y < min(at.y + 2, end.y); ++y)
            for (int x = max(at.x - 1, first.x); x < min(at.x + 2, end.x); ++x)
                atomicMax(&d.activity[d.lattice.block_of({4 * x, 4 * y, 4 * z})], min_of_them);
}

__global__ void __launch_bounds__(threads) stamp_kernel(const __grid_constant__ StampView d)
{
    const int b = int(blockIdx.x * threads + threadIdx.x);
    if (b >= d.blocks) return;
    const int activity = d.activity[b];
    d.free[b] = activity >= awake ? 0 : never;
    d.guard[b] = activity >= guard ? 0 : never;
    d.reached[b] = activity >= support;
    if (activity >= awake) d.changed[b] = d.clock->done + 1;
}

}  // namespace

void update_activity(const Views& views, cudaStream_t stream)
{
    const int blocks = blocks_for(views.lattice.block_count(), threads);
    const ProfilerRange range{"rest"};
    launch("rest activity", activity_kernel, blocks, threads, stream, activity_view(views),
           blocks_for(views.particles[0].count, views.rest.run));
    for (const int activity : {moving, awake, guard})
        launch("rest spread", spread_kernel, blocks, threads, stream, spread_view(views), activity);
    launch("rest stamp", stamp_kernel, blocks, threads, stream, stamp_view(views));
}

}  // namespace knead::gpu
