// Particles in the order of their cells, so that a warp's particles share nodes, and lines of
// memory. A stable radix sort: equal keys keep the order they came in.
#include <cub/device/device_radix_sort.cuh>

#include "launch.cuh"
#include "stages.cuh"
#include "stencil.h"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

int key_bits(const Lattice<float>& lattice)
{
    return std::bit_width(unsigned(lattice.node_count() - 1));
}

template <bool rests>
__global__ void __launch_bounds__(threads)
    key_kernel(const __grid_constant__ Views d, unsigned* keys, int* order)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    const ParticleView& particles = d.particles[d.clock->side];
    if (i >= particles.count) return;
    const int key = d.lattice.index(base_node(particles.position(i), d.lattice.dx));
    keys[i] = unsigned(key);
    order[i] = i;
    if constexpr (rests) {
        const float4 v = particles.row(3, i);
        const unsigned bits = __float_as_uint(v.x * v.x + v.y * v.y + v.z * v.z);
        unsigned* fastest = d.rest.fastest + key / block_nodes;
        if (bits > __ldcg(fastest)) atomicMax(fastest, bits);
    }
}

__global__ void __launch_bounds__(threads)
    reorder_kernel(const __grid_constant__ Views d, const int* order)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    const int side = d.clock->side;
    const ParticleView &from = d.particles[side], &to = d.particles[side ^ 1];
    if (i >= from.count) return;
    const int j = order[i];
    UNROLL
    for (int r = 0; r < particle_rows; ++r) to.row(r, i) = from.row(r, j);
    to.ids[i] = from.ids[j];
}

// The same, where clay may be still: that which is lies at rest; runs are listed, and where each
// block's particles begin and end is noted.
template <int run>
__global__ void __launch_bounds__(run)
    settled_reorder_kernel(const __grid_constant__ Views d, const int* order, const unsigned* keys)
{
    const int i = int(blockIdx.x) * run + int(threadIdx.x);
    const int side = d.clock->side;
    const ParticleView &from = d.particles[side], &to = d.particles[side ^ 1];
    const bool valid = i < from.count;
    const int block = valid ? int(keys[i]) / block_nodes : 0;
    const int stir = valid ? d.rest.stir[block] : asleep;
    if (__syncthreads_or(stir != asleep) && threadIdx.x == 0) {
        d.rest.held[blockIdx.x] = 1;
        d.rest.list[atomicAdd(&d.clock->listed, 1)] = int(blockIdx.x);
    }
    if (!valid) return;
    Particle<float> q = from.load(order[i]);
    q.hold(stir < awake);
    if (q.still()) q.v = {}, q.C = {};
    to.store(i, q);
    to.ids[i] = from.ids[order[i]];
    if (i == 0 || int(keys[i - 1]) / block_nodes != block) d.rest.range[block].x = i;
    if (i + 1 == from.count || int(keys[i + 1]) / block_nodes != block)
        d.rest.range[block].y = i + 1;
}

__global__ void flip_kernel(Clock* clock)
{
    clock->side ^= 1;
    clock->drift = 0;
}

cudaError_t radix_sort(const SortSpace& s, std::size_t& bytes, int count, int bits,
                       cudaStream_t stream)
{
    return cub::DeviceRadixSort::SortPairs(s.scratch, bytes, s.keys, s.sorted_keys, s.order,
                                           s.sorted_order, count, 0, bits, stream);
}

}  // namespace

std::size_t sort_scratch_bytes(int count, const Lattice<float>& lattice)
{
    std::size_t bytes = 0;
    check(radix_sort({}, bytes, count, key_bits(lattice), nullptr), "sort");
    return bytes;
}

void order(const Views& views, const Needs& needs, const SortSpace& space, cudaStream_t stream)
{
    const int count = views.particles[0].count;
    const ProfilerRange range{"sort"};
    launch("sort keys", needs.rests ? key_kernel<true> : key_kernel<false>,
           blocks_for(count, threads), threads, stream, views, space.keys, space.order);
    std::size_t bytes = space.scratch_bytes;
    check(radix_sort(space, bytes, count, key_bits(views.lattice), stream), "sort");
}

void arrange(const Views& views, const Needs& needs, const SortSpace& space, cudaStream_t stream)
{
    const int count = views.particles[0].count;
    const ProfilerRange range{"sort"};
    if (needs.rests) {
        const int run = run_length(needs);
        launch("sort reorder",
               run == run_length(true) ? settled_reorder_kernel<run_length(true)>
                                       : settled_reorder_kernel<run_length(false)>,
               blocks_for(count, run), run, stream, views, space.sorted_order, space.sorted_keys);
    } else {
        launch("sort reorder", reorder_kernel, blocks_for(count, threads), threads, stream, views,
               space.sorted_order);
    }
    launch("sort flip", flip_kernel, 1, 1, stream, views.clock);
}

}  // namespace knead::gpu
