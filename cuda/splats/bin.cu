// From splats to lists of splats per tile: sorts by depth, then finds the tiles, or the parts of
// tiles, that each splat reaches, in that order.
#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/transform_iterator.h>

#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>
#include <cuda/atomic>

#include "cuda/device/launch.cuh"
#include "cuda/splats/raster.cuh"

namespace knead::gpu {
namespace {

using Wide = unsigned long long;

constexpr int threads = 256, warps = threads / 32;
constexpr int stretch = chunk_size / warps;  // candidates of a warp
constexpr int blocks_each = 5;               // per multiprocessor
constexpr int blocks = 132 * blocks_each;    // of an H200's
constexpr int depth_bits = 24;
constexpr int sampled_chunks = 32 * sampling / stretch;  // 1 in this many: 32 per stretch
static_assert(sampled_chunks * stretch == 32 * sampling);

cudaError_t depth_sort(const RasterView& d, void* scratch, std::size_t& bytes, cudaStream_t stream)
{
    return cub::DeviceRadixSort::SortPairs(scratch, bytes, d.depth_keys, d.sorted_keys, d.numbers,
                                           d.order, d.count, 0, depth_bits, stream);
}

__device__ int tiles_in(const TileBox& b) { return int(b.columns) * int(b.rows); }

// Number of tiles of both eyes that the splat of a given depth rank may touch.
struct CandidatesOf {
    const std::uint32_t* keys;
    const int* order;
    const TileBoxes* boxes;
    int count;

    __device__ Wide operator()(int rank) const
    {
        if (rank >= count || keys[rank] == no_depth_key) return 0;
        const TileBoxes b = boxes[order[rank]];
        return Wide(tiles_in(b.eye[0]) + tiles_in(b.eye[1]));
    }
};

cudaError_t candidate_scan(const RasterView& d, void* scratch, std::size_t& bytes,
                           cudaStream_t stream)
{
    const auto counts = thrust::make_transform_iterator(
        thrust::make_counting_iterator(0), CandidatesOf{d.sorted_keys, d.order, d.boxes, d.count});
    return cub::DeviceScan::ExclusiveSum(scratch, bytes, counts, d.candidate_starts, d.count + 1,
                                         stream);
}

__device__ Footprint<float> shape_of(const RasterView& d, int record)
{
    const float4* const from = reinterpret_cast<const float4*>(d.shapes + record);
    const float4 p = from[0], q = from[1];
    Footprint<float> f;
    f.u = p.x, f.v = p.y, f.a = p.z, f.b = p.w, f.c = q.x, f.peak = q.y;
    return f;
}

// Rank of the splat to which a candidate belongs. A warp probes 32 positions at a time.
__device__ int rank_of(const RasterView& d, Wide candidate)
{
    const int lane = int(threadIdx.x) % 32;
    int from = 0, to = d.count;  // starts[from] <= candidate < starts[to]
    while (to - from > 1) {
        const int probe = from + int((long long)(to - from) * (lane + 1) / 33);
        const int below = __popc(__ballot_sync(~0u, d.candidate_starts[probe] <= candidate));
        const int next = __shfl_sync(~0u, probe, min(below, 31));
        const int last = __shfl_sync(~0u, probe, max(below - 1, 0));
        if (below < 32) to = next;
        if (below > 0) from = last;
    }
    return from;
}

// 32 consecutive splats in order of depth, one per lane.
struct Window {
    int start;        // of its candidates, relative to the warp's stretch
    int splat, left;  // its number of tiles in the first eye
    TileBoxes boxes;
};

__device__ Window window_at(const RasterView& d, int rank, Wide from, int count)
{
    Window w{count, 0, 0, {}};
    if (rank >= d.count) return w;
    const Wide start = d.candidate_starts[rank];
    if (start >= from + unsigned(count)) return w;
    w.start = int((long long)(start - from));
    w.splat = d.order[rank];
    w.boxes = d.boxes[w.splat];
    w.left = tiles_in(w.boxes.eye[0]);
    return w;
}

// Broadcasts a value of whole words from lane `from`.
template <class T>
__device__ T from_lane(const T& mine, int from)
{
    static_assert(sizeof(T) % 4 == 0);
    unsigned words[sizeof(T) / 4];
    memcpy(words, &mine, sizeof mine);
    UNROLL
    for (unsigned& w : words) w = __shfl_sync(~0u, w, from);
    T theirs;
    memcpy(&theirs, words, sizeof theirs);
    return theirs;
}

// The parts of the tile with first pixel (x, y) that a splat reaches, as bits.
__device__ unsigned parts_reached(const Footprint<float>& f, int x, int y, int step, unsigned drawn)
{
    unsigned found = 0;
    ROLLED
    for (int n = 0; n < parts; ++n)
        if (drawn >> n & 1 && reaches_part(f, x, y, part_box(n, step), step)) found |= 1u << n;
    return found;
}

// A splat in one tile of an eye.
struct Candidate {
    int record, tile, x, y;  // (x, y): the tile's first pixel
};

// The parts' lists of its tile that contain a candidate, as bits. The tile is tested first even for
// lists by parts, because a whole list contains only what reaches the tile.
__device__ unsigned lists_of(const RasterView& d, const Candidate& c, bool sampled)
{
    const TileOptions options = d.rules[c.tile];
    if (!options.drawn) return 0;
    const Footprint<float> f = shape_of(d, c.record);
    if (!reaches_part(f, c.x, c.y, {0, 0, tile_size, tile_size}, 1)) return 0;
    const bool whole = options.whole;
    if (whole && !sampled) return 1;
    const unsigned found = parts_reached(f, c.x, c.y, options.step, options.drawn);
    if (sampled) {
        atomicAdd(&d.samples[c.tile].splats, 1u);
        atomicAdd(&d.samples[c.tile].entries, unsigned(__popc(found)));
    }
    return whole ? 1 : found;
}

// The n-th tile of a splat, over both eyes.
__device__ Candidate candidate_of(const RasterView& d, const Window& w, int n)
{
    const int e = n >= w.left ? 1 : 0;
    const TileBox box = e == 0 ? w.boxes.eye[0] : w.boxes.eye[1];
    const int columns = max(int(box.columns), 1), of_eye = n - e * w.left, row = of_eye / columns;
    const int x = int(box.x) + of_eye - row * columns, y = int(box.y) + row;
    return {e * d.count + w.splat, (e * d.rows + y) * d.columns + x, x * tile_size, y * tile_size};
}

// Calls use(lists, candidate) for `count` candidates from `from` on, 32 at a time, in order of the
// splats. Warp-collective, as is `use`.
template <class Use>
__device__ void each_candidate(const RasterView& d, Wide from, int count, Use&& use)
{
    const int lane = int(threadIdx.x) % 32;
    int at = 0;
    for (int rank = count > 0 ? rank_of(d, from) : 0; at < count; rank += 32) {
        const Window mine = window_at(d, rank + lane, from, count);
        const Wide behind = d.candidate_starts[min(rank + 32, d.count)] - from;
        const int end = behind < unsigned(count) ? int(behind) : count;
        for (; at < end; at = min(at + 32, end)) {
            const int candidate = at + lane;
            int owner = 0;  // the last lane with start <= candidate
            UNROLL
            for (int step = 16; step > 0; step /= 2)
                if (__shfl_sync(~0u, mine.start, owner + step) <= candidate) owner += step;
            const bool in = candidate < end;
            const Window w = from_lane(mine, owner);
            const Candidate c = candidate_of(d, w, candidate - w.start);
            use(in ? lists_of(d, c, at == 0 && from / chunk_size % sampled_chunks == 0) : 0, c);
        }
    }
}

// State of a chunk, in one word: none yet, its number of instances, or the number of instances of
// all chunks up to and including it (decoupled look-back). [Merrill 2016]
constexpr int state_bit = 62;
constexpr Wide own = Wide(1) << state_bit, total = Wide(2) << state_bit, value_bits = own - 1;

// Instances of all chunks before; `sum` is this chunk's. By one warp.
__device__ Wide sum_before(const RasterView& d, int chunk, Wide sum)
{
    const int lane = int(threadIdx.x) % 32;
    const auto state = [&](int k) {
        return cuda::atomic_ref<Wide, cuda::thread_scope_device>(d.chunk_states[k]);
    };
    if (lane == 0 && chunk > 0) state(chunk).store(own | sum, cuda::memory_order_relaxed);
    Wide before = 0;
    for (int last = chunk - 1; last >= 0; last -= 32) {
        const int k = last - lane;
        Wide word = total;  // zero before the first chunk
        if (k >= 0) do
                word = state(k).load(cuda::memory_order_relaxed);
            while (word >> state_bit == 0);
        const unsigned totals = __ballot_sync(~0u, word >> state_bit == 2);
        const int until = totals ? lowest_bit(totals) : 31;
        Wide part = lane <= until ? word & value_bits : 0;
        UNROLL
        for (int step = 16; step > 0; step /= 2) part += __shfl_xor_sync(~0u, part, step);
        before += part;
        if (totals) break;
    }
    if (lane == 0) state(chunk).store(total | (before + sum), cuda::memory_order_relaxed);
    return before;
}

// Results of a warp: `count` candidates in lists, with `instances` in total.
struct Found {
    int records[stretch];
    std::uint16_t tiles[stretch];
    unsigned char lists[stretch];
};
struct FoundCounts {
    int count;
    unsigned instances;
};

// Tests a warp's stretch.
__device__ FoundCounts find(const RasterView& d, Wide from, Wide all, Found& found)
{
    const unsigned before = (1u << (threadIdx.x % 32)) - 1;
    const int count = from < all ? int(min(all - from, Wide(stretch))) : 0;
    int sum = 0;
    unsigned instances = 0;  // per lane
    each_candidate(d, from, count, [&](unsigned lists, const Candidate& c) {
        const unsigned lanes = __ballot_sync(~0u, lists != 0);
        const int at = sum + __popc(lanes & before);
        if (lists) {
            found.records[at] = c.record, found.tiles[at] = std::uint16_t(c.tile);
            found.lists[at] = (unsigned char)(lists);
        }
        sum += __popc(lanes), instances += unsigned(__popc(lists));
    });
    return {sum, __reduce_add_sync(~0u, instances)};
}

// Writes a warp's results from `at` on, as far as there is room.
__device__ void write(const RasterView& d, const Found& found, int count, Wide at)
{
    const int lane = int(threadIdx.x) % 32;
    const Wide room = unsigned(d.room);
    for (int first = 0; first < count && at < room; first += 32) {
        const int i = first + lane;
        const bool in = i < count;
        unsigned lists = in ? found.lists[i] : 0;
        const int record = in ? found.records[i] : 0, key = in ? found.tiles[i] * parts : 0;
        unsigned until = unsigned(__popc(lists));  // inclusive sum over lanes
        UNROLL
        for (int step = 1; step < 32; step *= 2) {
            const unsigned below = __shfl_up_sync(~0u, until, unsigned(step));
            if (lane >= step) until += below;
        }
        Wide to = at + (until - unsigned(__popc(lists)));
        for (; lists && to < room; lists &= lists - 1, ++to) {
            d.keys[0][to] = std::uint16_t(key + lowest_bit(lists));
            d.records[0][to] = record;
        }
        at += __shfl_sync(~0u, until, 31);
    }
}

// Writes the frame's counts. By the last chunk; `listed` instances were found up to its end.
__device__ void count_all(const RasterView& d, Wide listed, Wide not_looked_at)
{
    const Wide room = unsigned(d.room), kept = listed < room ? listed : room;
    d.counts->listed = kept;
    d.counts->instances = listed + not_looked_at;
    d.counts->dropped = listed + not_looked_at - kept;
}

// Chooses from samples of the previous frame; there are none after a change of size.
__global__ void __launch_bounds__(threads) choose_kernel(const __grid_constant__ RasterView d)
{
    const int tile = int(blockIdx.x) * threads + int(threadIdx.x);
    if (tile >= d.all_tiles()) return;
    const int eye = tile / d.tiles_of_eye(), row = tile / d.columns;
    const int x = (tile - row * d.columns) * tile_size, y = (row - eye * d.rows) * tile_size;
    const int step = fovea_step(d.frame->fovea[eye], d.frame->camera[eye], x, y);
    const unsigned drawn = drawn_parts(d.seen_parts[tile], step);
    const TileSample s = d.samples[tile];
    d.rules[tile] = {(unsigned char)(drawn), (unsigned char)(step),
                     prefer_whole_list(s.splats, s.entries, __popc(drawn))};
    d.samples[tile] = {0, 0};
}

// Chunks are taken in order: a block waits only for chunks taken before.
__global__ void __launch_bounds__(threads, blocks_each)
    emit_kernel(const __grid_constant__ RasterView d)
{
    __shared__ Found found[warps];
    __shared__ unsigned sums[warps];
    __shared__ int taken;
    __shared__ Wide before;
    const int t = int(threadIdx.x), warp = t / 32, lane = t % 32;
    const Wide all = d.candidate_starts[d.count];
    const int chunks = int(min((all + chunk_size - 1) / chunk_size, Wide(d.chunks)));
    if (blockIdx.x == 0 && warp == 0 && all > 0) {
        const int last = rank_of(d, all - 1);
        if (lane == 0) d.counts->visible = unsigned(last) + 1;
    }
    for (;;) {
        if (t == 0) taken = atomicAdd(&d.counts->next_chunk, 1);
        __syncthreads();
        const int chunk = taken;
        if (chunk >= chunks) return;
        const FoundCounts mine =
            find(d, Wide(chunk) * chunk_size + unsigned(warp * stretch), all, found[warp]);
        if (lane == 0) sums[warp] = mine.instances;
        __syncthreads();
        if (warp == 0) {
            Wide of_all = 0;
            for (const unsigned s : sums) of_all += s;
            const Wide b = sum_before(d, chunk, of_all);
            if (lane == 0) {
                before = b;
                const Wide looked_at = Wide(chunks) * chunk_size;
                if (chunk == chunks - 1)
                    count_all(d, b + of_all, all > looked_at ? parts * (all - looked_at) : 0);
            }
        }
        __syncthreads();
        Wide at = before;
        for (int w = 0; w < warp; ++w) at += sums[w];
        write(d, found[warp], mine.count, at);
        __syncthreads();
    }
}

}  // namespace

std::size_t raster_scratch_bytes(int splats)
{
    RasterView d{};
    d.count = splats;
    std::size_t depth = 0, scan = 0;
    check(depth_sort(d, nullptr, depth, nullptr), "sort");
    check(candidate_scan(d, nullptr, scan, nullptr), "scan");
    return max(tile_sort_scratch_bytes(), max(depth, scan));
}

void sort_by_depth(const RasterView& view, const RasterScratch& s, cudaStream_t stream)
{
    const ProfilerRange range{"sort"};
    std::size_t bytes = s.bytes;
    check(depth_sort(view, s.memory, bytes, stream), "sort");
}

void scan_candidates(const RasterView& view, const RasterScratch& s, cudaStream_t stream)
{
    const ProfilerRange range{"scan"};
    std::size_t bytes = s.bytes;
    check(candidate_scan(view, s.memory, bytes, stream), "scan");
}

void emit(const RasterView& view, cudaStream_t stream)
{
    check(cudaMemsetAsync(view.counts, 0, sizeof *view.counts, stream), "emit");
    check(cudaMemsetAsync(view.chunk_states, 0, std::size_t(view.chunks) * sizeof(Wide), stream),
          "emit");
    launch("emit", choose_kernel, blocks_for(view.all_tiles(), threads), threads, stream, view);
    launch("emit", emit_kernel, blocks, threads, stream, view);
}

}  // namespace knead::gpu
