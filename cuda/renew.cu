// Before a surface: of which blocks it must be made anew, because clay that may have moved since
// the last one reaches them, or their neighbours so far as softening carries.
#include "launch.cuh"
#include "surface.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

// Whether clay that may have moved since the substep `seen` reaches any of the density's nodes
// low <= n <= high: stencils reach 1.5 spacings on either lattice, and half of one is for rounding.
__device__ bool reached(const SurfaceView& d, const Clay& clay, int seen, Int3 low, Int3 high)
{
    const float ratio = d.lattice.dx / clay.lattice.dx;
    const Int3 size = clay.lattice.blocks();
    const auto first = [ratio](int n, int blocks) {
        return clamped(int(floorf(ratio * float(n - 2) - 1)) >> 2, 0, blocks - 1);
    };
    const auto last = [ratio](int n, int blocks) {
        return clamped(int(floorf(ratio * float(n + 2))) >> 2, 0, blocks - 1);
    };
    const Int3 to = {last(high.x, size.x), last(high.y, size.y), last(high.z, size.z)};
    for (int z = first(low.z, size.z); z <= to.z; ++z)
        for (int y = first(low.y, size.y); y <= to.y; ++y)
            for (int x = first(low.x, size.x); x <= to.x; ++x)
                if (clay.changed[(z * size.y + y) * size.x + x] > seen) return true;
    return false;
}

// Bits of Anew of block b of one category.
__device__ unsigned renewed(const SurfaceView& d, const Clay& clay, int seen, int b)
{
    const Int3 one{1, 1, 1};
    const Int3 low = block_edge * d.padded.block_at(b) - one, high = low + (block_edge - 1) * one;
    const Int3 lower = low - d.reach * one, beyond = high + block_edge * one,
               higher = high + d.reach * one;
    const Int3 farthest = d.reach > block_edge ? higher : beyond;
    if (!reached(d, clay, seen, lower, farthest)) return 0;
    unsigned anew = reached(d, clay, seen, lower, higher) ? nodes_anew : 0;
    if (reached(d, clay, seen, low, beyond)) anew |= near_anew;
    if (anew == (nodes_anew | near_anew) && reached(d, clay, seen, low, high)) anew |= sums_anew;
    return anew;
}

__global__ void __launch_bounds__(threads)
    renew_kernel(const __grid_constant__ SurfaceView d, const __grid_constant__ Clay clay)
{
    const int b = int(blockIdx.x) * threads + int(threadIdx.x), seen = *d.seen;
    // A sum that has overflowed cannot be mended in part.
    const bool whole = !clay.changed || seen < 0 || d.faults->crowded;
    unsigned anew = 0;
    if (b < d.layer_blocks())
        d.anew[b] = anew = whole ? unsigned(all_anew) : renewed(d, clay, seen, b);
    const int all = __syncthreads_count(anew & nodes_anew);
    if (threadIdx.x != 0) return;
    if (all) atomicAdd(&d.progress->anew, all);
    if (whole && b == 0) d.progress->whole = 1;
}

}  // namespace

void renew(const SurfaceView& view, const Clay& clay, cudaStream_t stream)
{
    check(cudaMemsetAsync(view.progress, 0, sizeof(Progress), stream), "surface renew");
    launch("surface renew", renew_kernel, blocks_for(view.layer_blocks(), threads), threads, stream,
           view, clay);
}

}  // namespace knead::gpu
