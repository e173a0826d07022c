// Grid update: one thread block per listed block of nodes, as many as there are, however many the
// launch brings. The grid of the substep before is cleared on the way.
#include "grid.h"
#include "launch.cuh"
#include "stages.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = block_nodes;

template <bool fixed_point>
__device__ Node<float> sum_of(const GridView& grid, int parity, int i)
{
    if constexpr (fixed_point) {
        const longlong2* at =
            reinterpret_cast<const longlong2*>(grid.sums[parity] + 4 * std::size_t(i));
        const longlong2 a = at[0], b = at[1];
        const double p = 1 / double(grid.momentum_scale), m = 1 / double(grid.mass_scale);
        return {{float(p * double(a.x)), float(p * double(a.y)), float(p * double(b.x))},
                float(m * double(b.y))};
    } else {
        const float4 n = grid.nodes[parity][i];
        return {{n.x, n.y, n.z}, n.w};
    }
}

template <bool fixed_point>
__device__ void clear(const GridView& grid, int parity, int i)
{
    if constexpr (fixed_point) {
        longlong2* at = reinterpret_cast<longlong2*>(grid.sums[parity] + 4 * std::size_t(i));
        at[0] = at[1] = longlong2{0, 0};
    } else {
        grid.nodes[parity][i] = {0, 0, 0, 0};
    }
}

template <bool tools, bool fixed_point>
__global__ void __launch_bounds__(threads, 12) grid_kernel(const __grid_constant__ Views d)
{
    const int parity = d.clock->parity;
    const float dt = float(d.clock->dt);
    const int count = d.clock->active[parity], cleared = d.clock->active[parity ^ 1];
    for (int at = int(blockIdx.x); at < count; at += int(gridDim.x)) {
        const int b = d.grid.list[parity][at], i = b * block_nodes + int(threadIdx.x);
        bool clipped;
        const Node<float> node =
            update(sum_of<fixed_point>(d.grid, parity, i), d.lattice.node_at(i), d.lattice, d.walls,
                   d.gravity, dt, clipped, [&](Vec3<float> x, Vec3<float> v) {
                       if constexpr (tools)
                           return held(d.tools.colliders(), d.tools.masks[b], x, v);
                       return v;
                   });
        d.grid.nodes[parity][i] = {node.p.x, node.p.y, node.p.z, node.m};
        if (clipped) atomicAdd(&d.clock->counters.clipped, 1ull);
    }
    for (int at = int(blockIdx.x); at < cleared; at += int(gridDim.x)) {
        const int b = d.grid.list[parity ^ 1][at];
        clear<fixed_point>(d.grid, parity ^ 1, b * block_nodes + int(threadIdx.x));
        if (threadIdx.x == 0) d.grid.touched[parity ^ 1][b] = 0;
    }
}

}  // namespace

void grid(const Views& views, const Needs& needs, int multiprocessors, cudaStream_t stream)
{
    const bool tools = needs.tools && views.tools.grid_contact;
    const auto kernel = needs.fixed_point
                            ? (tools ? grid_kernel<true, true> : grid_kernel<false, true>)
                            : (tools ? grid_kernel<true, false> : grid_kernel<false, false>);
    const int blocks = least(views.lattice.block_count(), 16 * multiprocessors);
    launch("grid", kernel, blocks, threads, stream, views);
}

}  // namespace knead::gpu
