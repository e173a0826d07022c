#include "cuda/device/launch.cuh"
#include "cuda/splats/spread.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 256;
static_assert(spread_rounds % 2 == 1);  // the last round ends in the spare depths

__global__ void __launch_bounds__(threads) add_kernel(const __grid_constant__ DepthView d)
{
    unsigned long long units = 0, pixels = 0;
    for (int i = int(blockIdx.x) * threads + int(threadIdx.x); i < d.width * d.height;
         i += int(gridDim.x) * threads)
        if (const float depth = d.depth[i]; depth < no_depth)
            units += counted_depth(depth), ++pixels;
    UNROLL
    for (int step = 16; step > 0; step /= 2) {
        units += __shfl_xor_sync(~0u, units, step);
        pixels += __shfl_xor_sync(~0u, pixels, step);
    }
    if (threadIdx.x % 32 != 0 || pixels == 0) return;
    atomicAdd(&d.sum->units, units);
    atomicAdd(&d.sum->pixels, pixels);
}

__global__ void __launch_bounds__(threads)
    spread_kernel(const __grid_constant__ DepthView d, const float* from, float* to)
{
    const int i = int(blockIdx.x) * threads + int(threadIdx.x);
    if (i >= d.width * d.height) return;
    float own = from[i];
    if (!(own < no_depth)) {
        const int x = i % d.width, y = i / d.width;
        own = spread_depth(
            own, x > 0 ? from[i - 1] : no_depth, x + 1 < d.width ? from[i + 1] : no_depth,
            y > 0 ? from[i - d.width] : no_depth, y + 1 < d.height ? from[i + d.width] : no_depth);
    }
    to[i] = own;
}

__global__ void __launch_bounds__(threads) fill_kernel(const __grid_constant__ DepthView d)
{
    const int i = int(blockIdx.x) * threads + int(threadIdx.x);
    if (i >= d.width * d.height) return;
    const bool covered = (d.colour[i].y >> 16 & 0x7fff) != 0;  // a half that is not zero
    d.depth[i] = filled_depth(d.spare[i], covered, *d.sum);
}

}  // namespace

void spread(const DepthView& view, int processors, cudaStream_t stream)
{
    const int blocks = blocks_for(view.width * view.height, threads);
    check(cudaMemsetAsync(view.sum, 0, sizeof(DepthSum), stream), "splats");
    launch("splats add depths", add_kernel, min(blocks, 8 * processors), threads, stream, view);
    const float* from = view.depth;
    float* to = view.spare;
    for (int round = 0; round < spread_rounds; ++round) {
        launch("splats spread", spread_kernel, blocks, threads, stream, view, from, to);
        from = to, to = to == view.spare ? view.depth : view.spare;
    }
    launch("splats fill", fill_kernel, blocks, threads, stream, view);
}

}  // namespace knead::gpu
