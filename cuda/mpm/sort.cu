// Sorts the particles by cell, so that a warp's particles share nodes and cache lines. Counting
// sort by node, with an arbitrary order within a node; for fixed_point a stable radix sort, twice
// as slow. Both work in a free row of particles.cuh and write the order to the ids that are not
// current. Then the rows are moved in that order: all together if there is space, else one after
// the other, each into the row that the previous one has left.
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

#include "cuda/device/launch.cuh"
#include "cuda/mpm/stages.cuh"
#include "cuda/mpm/stencil.h"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

// In entries of the order, for still particles: there are fewer than 2^31.
constexpr unsigned still_bit = Particle<float>::still_bit;

int key_bits(const Lattice<float>& lattice)
{
    return std::bit_width(unsigned(lattice.node_count() - 1));
}

constexpr Features relevant(Features f) { return {.rests = f.rests}; }
constexpr Features relevant_to_runs(Features f) { return {.blades = f.blades}; }

// Rank of the particle within its node; one atomic per node and warp.
__device__ int counted(int* counts, int key)
{
    const unsigned lane = threadIdx.x & 31, lanes = __match_any_sync(0xffffffffu, key);
    const int first = __ffs(int(lanes)) - 1;
    int before = 0;
    if (int(lane) == first && key >= 0) before = atomicAdd(counts + key, __popc(lanes));
    return __shfl_sync(0xffffffffu, before, first) + __popc(lanes & ((1u << lane) - 1));
}

// Keys and order while `side` is current: in the free row, except for the final order, which
// replaces the other side's ids.
struct Listing {
    unsigned* keys;  // count
    int* order;      // count
};
HD Listing listing(const ParticleView (&sides)[2], int side, bool done)
{
    static_assert(sizeof(float4) >= 2 * sizeof(unsigned) + sizeof(int));
    const std::size_t count = std::size_t(sides[0].count);
    unsigned* const keys = reinterpret_cast<unsigned*>(free_row(sides, side));
    if (done) return {keys, sides[side ^ 1].ids};
    return {keys + count, reinterpret_cast<int*>(keys + 2 * count)};
}

// Keys, and either each particle's rank within its node (counting sort, with `counts`) or the
// current order (radix sort).
template <class Case>
__global__ void __launch_bounds__(threads)
    key_kernel(const __grid_constant__ KeyView d, int* counts, bool done)
{
    const int i = int(blockIdx.x * threads + threadIdx.x), side = d.clock->side;
    const ParticleView& particles = d.particles[side];
    const bool valid = i < particles.count;
    if (i == 0) d.clock->sorted_from = side;
    const int key =
        valid ? d.lattice.index(base_node(particles.position(i), d.lattice.spacing)) : -1;
    const int place = counts ? counted(counts, key) : i;
    if (!valid) return;
    const Listing l = listing(d.particles, side, done);
    l.keys[i] = unsigned(key);
    l.order[i] = place;
    if constexpr (Case::features.rests) {
        const float4 v = particles.row(3, i);
        const unsigned bits = __float_as_uint(v.x * v.x + v.y * v.y + v.z * v.z);
        unsigned* fastest = d.fastest + key / block_nodes;
        if (bits > __ldcg(fastest)) atomicMax(fastest, bits);
    }
}

// The counts have become the first index of each node.
template <class Case>
__global__ void __launch_bounds__(threads)
    place_kernel(const __grid_constant__ SortView d, const int* starts)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= d.particles[0].count) return;
    const int side = d.clock->side;
    const Listing from = listing(d.particles, side, false), to = listing(d.particles, side, true);
    const unsigned key = from.keys[i];
    const int at = starts[key] + from.order[i];
    to.order[at] = i;
    if constexpr (Case::features.rests) to.keys[at] = key;  // read by settled_kernel
}

// Sleep: sets the bit of still particles in the order, lists the runs, and records each block's
// range of particles.
template <class Case>
__global__ void __launch_bounds__(run_length(Case::features))
    settled_kernel(const __grid_constant__ SettledView d)
{
    constexpr int run = run_length(Case::features);
    const int i = int(blockIdx.x) * run + int(threadIdx.x), side = d.clock->sorted_from;
    const int count = d.particles[0].count;
    const unsigned* keys = listing(d.particles, side, true).keys;
    const bool valid = i < count;
    const int block = valid ? int(keys[i]) / block_nodes : 0;
    const int activity = valid ? d.activity[block] : asleep;
    if (__syncthreads_or(activity != asleep) && threadIdx.x == 0) {
        d.run_listed[blockIdx.x] = 1;
        d.list[atomicAdd(&d.clock->listed, 1)] = int(blockIdx.x);
    }
    if (!valid) return;
    if (activity < awake) d.particles[side ^ 1].ids[i] |= int(still_bit);
    if (i == 0 || int(keys[i - 1]) / block_nodes != block) d.range[block].x = i;
    if (i + 1 == count || int(keys[i + 1]) / block_nodes != block) d.range[block].y = i + 1;
}

// Moves the k-th row, or `together` rows from k on. The last row switches the current side.
template <class Case, int together>
__global__ void __launch_bounds__(threads) move_kernel(const __grid_constant__ SortView d, int k)
{
    const int i = int(blockIdx.x * threads + threadIdx.x), side = d.clock->sorted_from;
    const ParticleView &from = d.particles[side], &to = d.particles[side ^ 1];
    const bool valid = i < from.count, last = k == particle_rows - together;
    const unsigned place = valid ? unsigned(to.ids[i]) : 0u;
    const int j = int(place & ~still_bit);
    const auto row = [=](int t) { return side ? k + t : particle_rows - 1 - k - t; };
    float4 a[together];
    UNROLL
    for (int t = 0; t < together; ++t) {
        const unsigned still = Case::features.rests ? place & still_bit : 0;
        a[t] = row(t) > 2 && still ? float4{0, 0, 0, 0} : from.row(row(t), j);
        if (Case::features.rests && row(t) == 2)
            a[t].w = __uint_as_float((__float_as_uint(a[t].w) & ~still_bit) | still);
    }
    const int id = last ? from.ids[j] : 0;
    if (!valid) return;
    UNROLL
    for (int t = 0; t < together; ++t) to.row(row(t), i) = a[t];
    if (last) to.ids[i] = id;
    if (last && i == 0) d.clock->side = side ^ 1, d.clock->drift = 0;
}

// CUB's radix sort alternates between two buffers and ends in one that depends on its number of
// passes. Started so that the result should end in place.
struct Passes {
    cub::DoubleBuffer<unsigned> keys;
    cub::DoubleBuffer<int> order;

    Passes(const Listing& done, const Listing& other, int bits)
        : keys(done.keys, other.keys), order(done.order, other.order)
    {
        constexpr int bits_of_a_pass = 8;
        keys.selector = order.selector = (bits + bits_of_a_pass - 1) / bits_of_a_pass % 2;
    }
    cudaError_t run(void* scratch, std::size_t& bytes, int count, int end, cudaStream_t stream)
    {
        return cub::DeviceRadixSort::SortPairs(scratch, bytes, keys, order, count, 0, end, stream);
    }
    // Copies the result if it is not in place.
    void finish(int count, cudaStream_t stream) const
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

// Exclusive prefix sum of `nodes` counts.
cudaError_t add_up(int* counts, int nodes, void* scratch, std::size_t& bytes, cudaStream_t stream)
{
    return cub::DeviceScan::ExclusiveSum(scratch, bytes, counts, counts, nodes, stream);
}

template <class... Arguments>
void launch_keys(const Views& views, const Features& features, cudaStream_t stream,
                 const Arguments&... arguments)
{
    launch("sort keys",
           dispatch<relevant>(features, []<class Case>(Case) { return key_kernel<Case>; }),
           blocks_for(views.particles[0].count, threads), threads, stream, key_view(views),
           arguments...);
}

void order_by_counting(const Views& views, const Features& features, const SortSpace& s,
                       cudaStream_t stream)
{
    const int nodes = views.lattice.node_count();
    launch_keys(views, features, stream, s.counts, false);
    std::size_t bytes = s.scratch_bytes;
    check(add_up(s.counts, nodes, s.scratch, bytes, stream), "sort");
    launch("sort place",
           dispatch<relevant>(features, []<class Case>(Case) { return place_kernel<Case>; }),
           blocks_for(views.particles[0].count, threads), threads, stream, sort_view(views),
           s.counts);
    check(cudaMemsetAsync(s.counts, 0, std::size_t(nodes) * sizeof s.counts[0], stream), "sort");
}

void order_stably(const Views& views, const Features& features, const SortSpace& s, int side,
                  cudaStream_t stream)
{
    const int count = views.particles[0].count, bits = key_bits(views.lattice);
    Passes passes(listing(views.particles, side, true), listing(views.particles, side, false),
                  bits);
    launch_keys(views, features, stream, s.counts, passes.keys.selector == 0);
    std::size_t bytes = s.scratch_bytes;
    check(passes.run(s.scratch, bytes, count, bits, stream), "sort");
    passes.finish(count, stream);
}

}  // namespace

std::size_t sort_scratch_bytes(int count, const Lattice<float>& lattice, const Features& features)
{
    std::size_t bytes = 0;
    if (features.fixed_point) {
        const int bits = key_bits(lattice);
        check(Passes({}, {}, bits).run(nullptr, bytes, count, bits, nullptr), "sort");
    } else {
        check(add_up(nullptr, lattice.node_count(), nullptr, bytes, nullptr), "sort");
    }
    return bytes;
}

void sort_particles(const Views& views, const Features& features, const SortSpace& space, int side,
                    cudaStream_t stream)
{
    const ProfilerRange range{"sort"};
    if (features.fixed_point)
        order_stably(views, features, space, side, stream);
    else
        order_by_counting(views, features, space, stream);
}

void arrange(const Views& views, const Features& features, cudaStream_t stream)
{
    const int count = views.particles[0].count, run = run_length(features);
    const ProfilerRange range{"sort"};
    if (features.rests)
        launch("sort settled",
               dispatch<relevant_to_runs>(features,
                                          []<class Case>(Case) { return settled_kernel<Case>; }),
               blocks_for(count, run), run, stream, settled_view(views));
    const SortView sides = sort_view(views);
    const int blocks = blocks_for(count, threads);
    const auto all = dispatch<relevant>(
        features, []<class Case>(Case) { return move_kernel<Case, particle_rows>; });
    if (apart(views.particles)) return launch("sort move", all, blocks, threads, stream, sides, 0);
    const auto one =
        dispatch<relevant>(features, []<class Case>(Case) { return move_kernel<Case, 1>; });
    for (int k = 0; k < particle_rows; ++k)
        launch("sort move", one, blocks, threads, stream, sides, k);
}

}  // namespace knead::gpu
