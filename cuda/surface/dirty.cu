// Selects the blocks to recompute: clay that may have moved since the last surface reaches them, or
// their neighbours within the width of the smoothing.
#include "cuda/device/launch.cuh"
#include "cuda/surface/surface.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;  // a warp per block of the density

// A box of simulation blocks, from the lowest corner to the highest.
struct Range {
    Int3 low, high;
    __device__ bool holds(Int3 b) const
    {
        return b.x >= low.x && b.y >= low.y && b.z >= low.z && b.x <= high.x && b.y <= high.y &&
               b.z <= high.z;
    }
};

// The simulation blocks whose particles can reach any density node low <= n <= high: stencils reach
// 1.5 spacings on either lattice; half a spacing is for rounding.
__device__ Range reaching(const SurfaceView& d, const Lattice<float>& lattice, Int3 low, Int3 high)
{
    const float ratio = d.lattice.dx / lattice.dx;
    const Int3 from = lattice.first_block, end = lattice.end_block();
    const auto first = [ratio](int n, int min, int past) {
        return clamp(int(floorf(ratio * float(n - 2) - 1)) >> 2, min, past - 1);
    };
    const auto last = [ratio](int n, int min, int past) {
        return clamp(int(floorf(ratio * float(n + 2))) >> 2, min, past - 1);
    };
    return {
        {first(low.x, from.x, end.x), first(low.y, from.y, end.y), first(low.z, from.z, end.z)},
        {last(high.x, from.x, end.x), last(high.y, from.y, end.y), last(high.z, from.z, end.z)}};
}

// Bits of Dirty of block b of one category, by a warp: each lane tests every 32nd simulation block
// in range.
__device__ unsigned dirty_bits(const SurfaceView& d, const Clay& clay, int last_substep, int b,
                               int lane)
{
    const Int3 one{1, 1, 1};
    const Int3 low = block_edge * d.padded.block_at(b) - one, high = low + (block_edge - 1) * one;
    const Int3 beyond = high + block_edge * one, lower = low - d.reach * one,
               higher = high + d.reach * one;
    const auto range = [&](Int3 from, Int3 to) { return reaching(d, clay.lattice, from, to); };
    const Range sums = range(low, high), near = range(low, beyond), nodes = range(lower, higher);
    const Range all = range(lower, d.reach > block_edge ? higher : beyond);
    const Int3 size = all.high - all.low + one;
    unsigned dirty = 0;
    for (int k = lane; k < size.x * size.y * size.z; k += 32) {
        const Int3 at = all.low + Int3{k % size.x, k / size.x % size.y, k / (size.x * size.y)};
        if (clay.changed[clay.lattice.block_of(block_edge * at)] <= last_substep) continue;
        dirty |= (sums.holds(at) ? sums_dirty : 0u) | (near.holds(at) ? near_dirty : 0u) |
                 (nodes.holds(at) ? nodes_dirty : 0u);
    }
    return __reduce_or_sync(~0u, dirty);
}

__global__ void __launch_bounds__(threads)
    renew_kernel(const __grid_constant__ SurfaceView d, const __grid_constant__ Clay clay)
{
    const int t = int(threadIdx.x), b = int(blockIdx.x) * (threads / 32) + t / 32,
              last_substep = *d.last_substep;
    // A sum that has overflowed cannot be corrected incrementally.
    const bool whole = last_substep < 0 || d.errors->overflowed;
    unsigned dirty = 0;
    if (b < d.layer_blocks())
        dirty = whole ? unsigned(all_dirty) : dirty_bits(d, clay, last_substep, b, t % 32);
    if (b < d.layer_blocks() && t % 32 == 0) d.dirty[b] = dirty;
    if (t % 32 == 0 && (dirty & nodes_dirty)) d.progress->dirty = 1;
}

}  // namespace

void mark_dirty(const SurfaceView& view, const Clay& clay, cudaStream_t stream)
{
    check(cudaMemsetAsync(view.progress, 0, sizeof(Progress), stream), "surface renew");
    launch("surface renew", renew_kernel, blocks_for(view.layer_blocks(), threads / 32), threads,
           stream, view, clay);
}

}  // namespace knead::gpu
