// Smoothing and shading: each vertex moves by its ring alone. A kernel per step: a grid-wide
// barrier within one kernel takes longer.
#include "cuda/device/launch.cuh"
#include "cuda/surface/advance.h"
#include "cuda/surface/smooth.h"
#include "cuda/surface/surface.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

__device__ Vec3<float> point(float4 a) { return {a.x, a.y, a.z}; }

__global__ void __launch_bounds__(threads, 4)
    relax_kernel(const __grid_constant__ SurfaceView d, int from, float factor)
{
    wait_upstream_and_trigger();
    const int count = vertex_count(d) * int(!unchanged(d));
    const float4* const x = d.vertices[from];
    for (int v = int(blockIdx.x) * threads + int(threadIdx.x); v < count;
         v += int(gridDim.x) * threads) {
        const Vec3<float> moved = relax(point(x[v]), d.ring[v], factor,
                                        [&](int k) { return point(x[d.next[d.at_ring(v, k)]]); });
        d.vertices[from ^ 1][v] = {moved.x, moved.y, moved.z, 1};
    }
}

// Advance of a vertex at x, from the densities of its category.
__device__ float advance_of(const SurfaceView& d, int v, Vec3<float> x)
{
    int category = 0;
    while (category < d.categories - 1 &&
           unsigned(v) >= unpacked(d.before[(category + 1) * d.layer_blocks()]).vertices)
        ++category;
    const std::size_t first = std::size_t(category) * std::size_t(d.layer_nodes());
    const Int3 size = d.padded.size;
    const auto of = [&](const float* density) {
        return [=, &d](Int3 n) {  // node n of `lattice` is n + 1 of `padded`
            return density[first + d.padded.index({clamp(n.x + 1, 0, size.x - 1),
                                                   clamp(n.y + 1, 0, size.y - 1),
                                                   clamp(n.z + 1, 0, size.z - 1)})];
        };
    };
    return advance(x, d.lattice.dx, of(d.final_density()), of(d.past));
}

template <bool moving>
__global__ void __launch_bounds__(threads, 4) shade_kernel(const __grid_constant__ SurfaceView d)
{
    wait_upstream_and_trigger();
    const bool no_change = unchanged(d);
    if (no_change && !moving) return;
    const int count = vertex_count(d);
    const bool known = moving && !no_change && *d.past_valid;
    const float4* const x = d.vertices[0];
    for (int v = int(blockIdx.x) * threads + int(threadIdx.x); v < count;
         v += int(gridDim.x) * threads) {
        if (no_change) {
            d.normals[v].w = 0;
            continue;
        }
        const Vec3<float> here = point(x[v]);
        const Vec3<float> normal = vertex_normal<float>(d.ring[v], [&](int k) {
            const std::size_t at = d.at_ring(v, k);
            return area_normal(here, point(x[d.next[at]]), point(x[d.last[at]]));
        });
        d.normals[v] = {normal.x, normal.y, normal.z, known ? advance_of(d, v, here) : 0};
    }
}

__global__ void __launch_bounds__(threads) remember_kernel(const __grid_constant__ SurfaceView d)
{
    if (unchanged(d)) return;
    const int all = d.categories * d.layer_nodes() / 4;
    const float4* const from = reinterpret_cast<const float4*>(d.final_density());
    for (int k = int(blockIdx.x) * threads + int(threadIdx.x); k < all;
         k += int(gridDim.x) * threads)
        reinterpret_cast<float4*>(d.past)[k] = from[k];
}

int blocks_of(const SurfaceView& view, int processors)
{
    return min(blocks_for(view.vertex_room, threads), 8 * processors);
}

}  // namespace

void relax(const SurfaceView& view, int from, float factor, int processors, cudaStream_t stream)
{
    launch_pdl("surface relax", relax_kernel, blocks_of(view, processors), threads, stream, view,
               from, factor);
}

void shade(const SurfaceView& view, int processors, cudaStream_t stream)
{
    launch_pdl("surface shade", view.past ? shade_kernel<true> : shade_kernel<false>,
               blocks_of(view, processors), threads, stream, view);
    if (view.past)  // any value but 0
        check(cudaMemsetAsync(view.past_valid, 1, sizeof(int), stream), "surface shade");
}

void save_densities(const SurfaceView& view, int processors, cudaStream_t stream)
{
    launch("surface remember", remember_kernel, 8 * processors, threads, stream, view);
}

}  // namespace knead::gpu
