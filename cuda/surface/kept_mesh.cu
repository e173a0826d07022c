#include <climits>

#include "cuda/device/launch.cuh"
#include "cuda/surface/kept_mesh.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 256;

__global__ void measure_kernel(const __grid_constant__ SurfaceView d, MeshInfo* facts)
{
    const Amounts all = unpacked(d.before[d.blocks]);
    const unsigned vertices = unsigned(vertex_count(d));
    *facts = {vertices,
              vertices ? all.triangles : 0,
              {INT_MAX, INT_MAX, INT_MAX},
              {INT_MIN, INT_MIN, INT_MIN},
              all,
              *d.errors};
}

struct Box {
    int low[3], high[3];
};

__device__ Box box_about(const float4* x, unsigned count, unsigned first, unsigned step)
{
    Box box{{INT_MAX, INT_MAX, INT_MAX}, {INT_MIN, INT_MIN, INT_MIN}};
    for (unsigned v = first; v < count; v += step) {
        const int side[3] = {ordered(__float_as_int(x[v].x)), ordered(__float_as_int(x[v].y)),
                             ordered(__float_as_int(x[v].z))};
        UNROLL
        for (int k = 0; k < 3; ++k) {
            box.low[k] = min(box.low[k], side[k]);
            box.high[k] = max(box.high[k], side[k]);
        }
    }
    return box;
}

__global__ void __launch_bounds__(threads) box_kernel(const float4* x, MeshInfo* facts)
{
    const Box box =
        box_about(x, facts->vertices, blockIdx.x * threads + threadIdx.x, gridDim.x * threads);
    UNROLL
    for (int k = 0; k < 3; ++k) {
        const int low = __reduce_min_sync(~0u, box.low[k]);
        const int high = __reduce_max_sync(~0u, box.high[k]);
        if (threadIdx.x % 32 != 0) continue;
        atomicMin(&facts->low[k], low);
        atomicMax(&facts->high[k], high);
    }
}

__global__ void __launch_bounds__(threads)
    copy_mesh_kernel(const __grid_constant__ MeshPlace from, const __grid_constant__ MeshPlace to,
                     int categories)
{
    const unsigned first = blockIdx.x * threads + threadIdx.x, step = gridDim.x * threads;
    const unsigned vertices = from.facts->vertices, corners = 3 * from.facts->triangles;
    for (unsigned v = first; v < vertices; v += step) {
        to.places[v] = from.places[v];
        to.normals[v] = from.normals[v];
    }
    const int* const corner = reinterpret_cast<const int*>(from.triangles);
    for (unsigned k = first; k < corners; k += step)
        reinterpret_cast<int*>(to.triangles)[k] = corner[k];
    for (unsigned c = first; c < unsigned(categories); c += step) to.draws[c] = from.draws[c];
}

int blocks_of(int processors) { return 8 * processors; }

}  // namespace

void keep_mesh(const SurfaceView& view, const MeshPlace& to, int processors, cudaStream_t stream)
{
    launch("surface measure", measure_kernel, 1, 1, stream, view, to.facts);
    const MeshPlace from{view.triangles, view.vertices[0], view.normals, view.draws, to.facts};
    launch("surface box", box_kernel, blocks_of(processors), threads, stream, from.places,
           to.facts);
    copy_mesh(from, to, view.categories, processors, stream);
}

void copy_mesh(const MeshPlace& from, const MeshPlace& to, int categories, int processors,
               cudaStream_t stream)
{
    launch("surface copy", copy_mesh_kernel, blocks_of(processors), threads, stream, from, to,
           categories);
}

}  // namespace knead::gpu
