// Particles in the order of their cells, so that a warp's particles share nodes, and lines of
// memory. A stable radix sort: equal keys keep the order they came in. It works in the row of
// particles.cuh that is free, and leaves the order in the ids that are not current; by that order
// the rows move, one after the other, into the row that the one before them has left.
#include <cub/device/device_radix_sort.cuh>

#include "launch.cuh"
#include "stages.cuh"
#include "stencil.h"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

// In an order, of particles that lie at rest: there are fewer than 2^31.
constexpr unsigned held_bit = Particle<float>::still_bit;

int key_bits(const Lattice<float>& lattice)
{
    return std::bit_width(unsigned(lattice.node_count() - 1));
}

template <bool rests>
__global__ void __launch_bounds__(threads)
    key_kernel(const __grid_constant__ Views d, int side, unsigned* keys, int* order)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    const ParticleView& particles = d.particles[side];
    if (i >= particles.count) return;
    if (i == 0) d.clock->sorted_from = side;
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

// Where clay may be still: what is gets its bit in the order; runs are listed, and where each
// block's particles begin and end is noted.
template <int run>
__global__ void __launch_bounds__(run) settled_kernel(const __grid_constant__ Views d)
{
    const int i = int(blockIdx.x) * run + int(threadIdx.x), side = d.clock->sorted_from;
    const int count = d.particles[0].count;
    const unsigned* keys = reinterpret_cast<const unsigned*>(free_row(d.particles, side));
    const bool valid = i < count;
    const int block = valid ? int(keys[i]) / block_nodes : 0;
    const int stir = valid ? d.rest.stir[block] : asleep;
    if (__syncthreads_or(stir != asleep) && threadIdx.x == 0) {
        d.rest.held[blockIdx.x] = 1;
        d.rest.list[atomicAdd(&d.clock->listed, 1)] = int(blockIdx.x);
    }
    if (!valid) return;
    if (stir < awake) d.particles[side ^ 1].ids[i] |= int(held_bit);
    if (i == 0 || int(keys[i - 1]) / block_nodes != block) d.rest.range[block].x = i;
    if (i + 1 == count || int(keys[i + 1]) / block_nodes != block) d.rest.range[block].y = i + 1;
}

// What moving the rows needs.
struct Sides {
    ParticleView particles[2];
    Clock* clock;
};

// The k-th row that moves. What it reads, none of the moves before it writes: only when it may
// write must they be over. With the last row the particles are on the other side.
template <bool rests>
__global__ void __launch_bounds__(threads) move_kernel(const __grid_constant__ Sides d, int k)
{
    let_next_in();
    const int i = int(blockIdx.x * threads + threadIdx.x), side = d.clock->sorted_from;
    const ParticleView &from = d.particles[side], &to = d.particles[side ^ 1];
    const int r = side ? k : particle_rows - 1 - k;
    const bool valid = i < from.count, last = k == particle_rows - 1;
    const unsigned place = valid ? unsigned(to.ids[i]) : 0u;
    const int j = int(place & ~held_bit);
    float4 a = from.row(r, j);
    if constexpr (rests) {
        const unsigned held = place & held_bit;
        if (r == 2) a.w = __uint_as_float((__float_as_uint(a.w) & ~held_bit) | held);
        if (r > 2 && held) a = {0, 0, 0, 0};
    }
    const int id = last ? from.ids[j] : 0;
    await_before();
    if (!valid) return;
    to.row(r, i) = a;
    if (last) to.ids[i] = id;
    if (last && i == 0) d.clock->side = side ^ 1, d.clock->drift = 0;
}

// CUB sorts to and fro, and ends where the number of its passes says. Begun so that this should be
// where the result belongs.
struct Passes {
    cub::DoubleBuffer<unsigned> keys;
    cub::DoubleBuffer<int> order;

    Passes(const SortSpace& s, int bits) : keys(s.keys, s.other_keys), order(s.order, s.other_order)
    {
        constexpr int bits_of_a_pass = 8;
        keys.selector = order.selector = (bits + bits_of_a_pass - 1) / bits_of_a_pass % 2;
    }
    cudaError_t run(void* scratch, std::size_t& bytes, int count, int end, cudaStream_t stream)
    {
        return cub::DeviceRadixSort::SortPairs(scratch, bytes, keys, order, count, 0, end, stream);
    }
    // Should it have ended elsewhere.
    void settle(int count, cudaStream_t stream) const
    {
        if (order.selector == 0) return;
        const auto bring = [&](auto* const(&buffers)[2]) {
            check(cudaMemcpyAsync(buffers[0], buffers[1], std::size_t(count) * sizeof *buffers[0],
                                  cudaMemcpyDeviceToDevice, stream),
                  "sort");
        };
        bring(keys.d_buffers), bring(order.d_buffers);
    }
};

}  // namespace

std::size_t sort_scratch_bytes(int count, const Lattice<float>& lattice)
{
    const int bits = key_bits(lattice);
    std::size_t bytes = 0;
    check(Passes({}, bits).run(nullptr, bytes, count, bits, nullptr), "sort");
    return bytes;
}

void order(const Views& views, const Needs& needs, const SortSpace& space, cudaStream_t stream)
{
    const int count = views.particles[0].count, bits = key_bits(views.lattice);
    const ProfilerRange range{"sort"};
    Passes passes(space, bits);
    launch("sort keys", needs.rests ? key_kernel<true> : key_kernel<false>,
           blocks_for(count, threads), threads, stream, views, space.side, passes.keys.Current(),
           passes.order.Current());
    std::size_t bytes = space.scratch_bytes;
    check(passes.run(space.scratch, bytes, count, bits, stream), "sort");
    passes.settle(count, stream);
}

void arrange(const Views& views, const Needs& needs, cudaStream_t stream)
{
    const int count = views.particles[0].count, run = run_length(needs);
    const ProfilerRange range{"sort"};
    if (needs.rests)
        launch("sort settled",
               run == run_length(true) ? settled_kernel<run_length(true)>
                                       : settled_kernel<run_length(false)>,
               blocks_for(count, run), run, stream, views);
    const auto move = needs.rests ? move_kernel<true> : move_kernel<false>;
    const Sides sides{{views.particles[0], views.particles[1]}, views.clock};
    const int blocks = blocks_for(count, threads);
    // The first reads what the kernel before it writes.
    launch("sort move", move, blocks, threads, stream, sides, 0);
    for (int k = 1; k < particle_rows; ++k)
        launch_early("sort move", move, blocks, threads, stream, sides, k);
}

}  // namespace knead::gpu
