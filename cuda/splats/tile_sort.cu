// Stable radix sort of instances by key; their number stays on the device. Two passes of 8 bits. In
// each, every thread block takes one contiguous range of instances and counts their digits; after a
// scan over all counts it moves the instances, one load at a time.
#include <cub/block/block_radix_rank.cuh>
#include <cub/device/device_scan.cuh>

#include "cuda/device/launch.cuh"
#include "cuda/splats/raster.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 256, digits = 256, digit_bits = 8;
constexpr int items = 12, load = threads * items;  // instances that a block moves at a time
constexpr int blocks_each = 3;                     // per multiprocessor
constexpr int blocks = 132 * blocks_each;          // of an H200's
static_assert(threads == digits);
static_assert(digit_table_size == digits * blocks);

struct Pass {
    const std::uint16_t* keys;
    const int* records;
    std::uint16_t* to_keys;
    int* to_records;
    unsigned* table;         // counts by digit, then by block
    const unsigned* starts;  // their exclusive prefix sums
    const unsigned long long* listed;
    int room, shift;
    uint2* ranges;  // null: another pass follows
};

// The instances of this thread block.
struct Stretch {
    int from, to;
};
__device__ Stretch stretch_of(const Pass& p)
{
    const long long count = (long long)*p.listed;
    const long long loads = (count + load - 1) / load, b = blockIdx.x;
    const long long from = loads * b / blocks * load, to = loads * (b + 1) / blocks * load;
    return {int(from < count ? from : count), int(to < count ? to : count)};
}

struct ByteAt {
    int shift;
    __device__ std::uint32_t Digit(std::uint32_t key) const { return key >> shift & (digits - 1); }
};

__global__ void __launch_bounds__(threads) tally_kernel(const __grid_constant__ Pass p)
{
    __shared__ unsigned tally[digits];
    const int t = int(threadIdx.x);
    const Stretch s = stretch_of(p);
    const ByteAt byte{p.shift};
    tally[t] = 0;
    __syncthreads();
    for (int i = s.from + t; i < s.to; i += threads) atomicAdd(&tally[byte.Digit(p.keys[i])], 1u);
    __syncthreads();
    p.table[t * blocks + int(blockIdx.x)] = tally[t];
}

// Shared memory of a block: first for ranking a load, then for writing it in order.
using Rank = cub::BlockRadixRankMatch<threads, digit_bits, false>;
struct Sorted {
    int records[load];
    std::uint16_t keys[load];
};
union Shared {
    typename Rank::TempStorage rank;
    Sorted sorted;
};

// Sorts the n instances from `first` on into shared memory; firsts[d] of them have a digit below d.
// A warp's instances are contiguous, 32 at a time.
__device__ void sort_load(const Pass& p, int first, int n, Shared& shared, int* firsts)
{
    const int t = int(threadIdx.x), base = t / 32 * 32 * items + t % 32;
    std::uint32_t keys[items];
    int records[items], ranks[items], below[1];
    UNROLL
    for (int k = 0; k < items; ++k) {
        const int i = base + 32 * k;  // padding sorts last
        keys[k] = i < n ? p.keys[first + i] : ~0u;
        records[k] = i < n ? p.records[first + i] : 0;
    }
    Rank(shared.rank).RankKeys(keys, ranks, ByteAt{p.shift}, below);
    firsts[t] = below[0];
    if (t == 0) firsts[digits] = n;
    __syncthreads();
    UNROLL
    for (int k = 0; k < items; ++k) {
        shared.sorted.keys[ranks[k]] = std::uint16_t(keys[k]);
        shared.sorted.records[ranks[k]] = records[k];
    }
    __syncthreads();
}

// Extends a key's range. Its instances are contiguous in a load; called for the first and the last.
__device__ void widen(const Pass& p, int key, unsigned at, bool first, bool last)
{
    if (first) atomicMax(&p.ranges[key].x, unsigned(p.room) - at);
    if (last) atomicMax(&p.ranges[key].y, at + 1);
}

__global__ void __launch_bounds__(threads, blocks_each) move_kernel(const __grid_constant__ Pass p)
{
    __shared__ Shared shared;
    __shared__ int firsts[digits + 1];
    __shared__ unsigned to[digits];  // target index of the load's first of a digit, less firsts
    const int t = int(threadIdx.x);
    const Stretch s = stretch_of(p);
    const ByteAt byte{p.shift};
    unsigned next = p.starts[t * blocks + int(blockIdx.x)];  // of the digit t
    for (int first = s.from; first < s.to; first += load) {
        const int n = min(load, s.to - first);
        sort_load(p, first, n, shared, firsts);
        to[t] = next - unsigned(firsts[t]);
        next += unsigned(firsts[t + 1] - firsts[t]);
        __syncthreads();
        for (int i = t; i < n; i += threads) {
            const std::uint16_t key = shared.sorted.keys[i];
            const unsigned at = to[byte.Digit(key)] + unsigned(i);
            p.to_keys[at] = key, p.to_records[at] = shared.sorted.records[i];
            if (p.ranges)
                widen(p, key, at, i == 0 || shared.sorted.keys[i - 1] != key,
                      i == n - 1 || shared.sorted.keys[i + 1] != key);
        }
        __syncthreads();
    }
}

cudaError_t table_scan(const RasterView& d, void* scratch, std::size_t& bytes, cudaStream_t stream)
{
    return cub::DeviceScan::ExclusiveSum(scratch, bytes, d.digit_counts, d.digit_starts,
                                         digit_table_size, stream);
}

}  // namespace

std::size_t tile_sort_scratch_bytes()
{
    std::size_t bytes = 0;
    check(table_scan({}, nullptr, bytes, nullptr), "sort by tile");
    return bytes;
}

void sort_by_tile(const RasterView& d, const RasterScratch& s, cudaStream_t stream)
{
    check(cudaMemsetAsync(d.ranges, 0, std::size_t(d.all_keys()) * sizeof *d.ranges, stream),
          "sort by tile");
    for (int k = 0; k < 2; ++k) {
        const Pass p{d.keys[k],         d.records[k],
                     d.keys[1 - k],     d.records[1 - k],
                     d.digit_counts,    d.digit_starts,
                     &d.counts->listed, d.room,
                     k * digit_bits,    k == 1 ? d.ranges : nullptr};
        launch("sort by tile", tally_kernel, blocks, threads, stream, p);
        std::size_t bytes = s.bytes;
        check(table_scan(d, s.memory, bytes, stream), "sort by tile");
        launch("sort by tile", move_kernel, blocks, threads, stream, p);
    }
}

}  // namespace knead::gpu
