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

__global__ void __launch_bounds__(threads)
    key_kernel(const __grid_constant__ Views d, unsigned* keys, int* order)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    const ParticleView& particles = d.particles[d.clock->side];
    if (i >= particles.count) return;
    keys[i] = unsigned(d.lattice.index(base_node(particles.position(i), d.lattice.dx)));
    order[i] = i;
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

__global__ void flip_kernel(Clock* clock) { clock->side ^= 1; }

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

void sort(const Views& views, const SortSpace& space, cudaStream_t stream)
{
    const int count = views.particles[0].count, blocks = blocks_for(count, threads);
    const ProfilerRange range{"sort"};
    launch("sort keys", key_kernel, blocks, threads, stream, views, space.keys, space.order);
    std::size_t bytes = space.scratch_bytes;
    check(radix_sort(space, bytes, count, key_bits(views.lattice), stream), "sort");
    launch("sort reorder", reorder_kernel, blocks, threads, stream, views, space.sorted_order);
    launch("sort flip", flip_kernel, 1, 1, stream, views.clock);
}

}  // namespace knead::gpu
