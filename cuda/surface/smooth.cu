// Smoothing and shading: a vertex looks at its ring and moves alone. Ready for the next move is
// every vertex when the kernel has ended: a barrier of all blocks within one kernel takes longer.
#include "cuda/device/launch.cuh"
#include "cuda/surface/smooth.h"
#include "cuda/surface/surface.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

__device__ Vec3<float> point(float4 a) { return {a.x, a.y, a.z}; }

__global__ void __launch_bounds__(threads, 4)
    relax_kernel(const __grid_constant__ SurfaceView d, int from, float factor)
{
    wait_for_upstream();
    const int count = vertex_count(d) * int(!idle(d));
    const float4* const x = d.vertices[from];
    for (int v = int(blockIdx.x) * threads + int(threadIdx.x); v < count;
         v += int(gridDim.x) * threads) {
        const Vec3<float> moved = relax(point(x[v]), d.ring[v], factor,
                                        [&](int k) { return point(x[d.next[d.at_ring(v, k)]]); });
        d.vertices[from ^ 1][v] = {moved.x, moved.y, moved.z, 1};
    }
}

__global__ void __launch_bounds__(threads, 4) shade_kernel(const __grid_constant__ SurfaceView d)
{
    wait_for_upstream();
    const int count = vertex_count(d) * int(!idle(d));
    const float4* const x = d.vertices[0];
    for (int v = int(blockIdx.x) * threads + int(threadIdx.x); v < count;
         v += int(gridDim.x) * threads) {
        const Vec3<float> here = point(x[v]);
        const Vec3<float> normal = vertex_normal<float>(d.ring[v], [&](int k) {
            const std::size_t at = d.at_ring(v, k);
            return area_normal(here, point(x[d.next[at]]), point(x[d.last[at]]));
        });
        d.normals[v] = {normal.x, normal.y, normal.z, 0};
    }
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
    launch_pdl("surface shade", shade_kernel, blocks_of(view, processors), threads, stream, view);
}

}  // namespace knead::gpu
