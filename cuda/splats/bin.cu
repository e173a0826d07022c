// From splats to lists of splats per tile: a sort by depth, instances in that order, and, after a
// stable sort by tile, where each tile's begin.
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

#include "cuda/device/launch.cuh"
#include "cuda/splats/raster.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 256;
constexpr int depth_bits = 24;
cudaError_t depth_sort(const RasterView& d, void* scratch, std::size_t& bytes, cudaStream_t stream)
{
    return cub::DeviceRadixSort::SortPairs(scratch, bytes, d.depth_keys, d.sorted_keys, d.numbers,
                                           d.order, d.splats.count, 0, depth_bits, stream);
}

cudaError_t group_scan(const RasterView& d, void* scratch, std::size_t& bytes, cudaStream_t stream)
{
    return cub::DeviceScan::ExclusiveSum(scratch, bytes, d.group_counts, d.group_starts,
                                         d.groups + 1, stream);
}

__device__ Footprint<float> shape_of(const RasterView& d, int record)
{
    const float4* const from = reinterpret_cast<const float4*>(d.shapes + record);
    const float4 p = from[0], q = from[1];
    Footprint<float> f;
    f.u = p.x, f.v = p.y, f.a = p.z, f.b = p.w, f.c = q.x, f.peak = q.y;
    return f;
}

// A lane's splat: how many tiles of either eye it may touch.
struct Candidates {
    int splat;
    TileBoxes boxes;
    int left, all;  // of the first eye, of both
};

__device__ Candidates candidates_of(const RasterView& d, int rank)
{
    Candidates c{};
    if (rank >= d.splats.count || d.sorted_keys[rank] == no_depth_key) return c;
    c.splat = d.order[rank];
    c.boxes = d.boxes[c.splat];
    const auto tiles = [](const TileBox& b) { return int(b.columns) * int(b.rows); };
    c.left = tiles(c.boxes.eye[0]), c.all = c.left + tiles(c.boxes.eye[1]);
    return c;
}

// The value of the lane `from`, of a thing of whole words.
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

// Calls use(reached, tile, record) for all candidates of a warp's splats, 32 at a time, in the
// order of the splats; the whole warp calls it, and calls `use` together. A splat of many tiles is
// shared by all lanes.
template <class Use>
__device__ void each_candidate(const RasterView& d, const Candidates& mine, Use&& use)
{
    const int lane = int(threadIdx.x) % 32;
    int up_to = mine.all;  // of the lanes up to this one
    UNROLL
    for (int step = 1; step < 32; step *= 2) {
        const int before = __shfl_up_sync(~0u, up_to, step);
        if (lane >= step) up_to += before;
    }
    const int all = __shfl_sync(~0u, up_to, 31);
    for (int base = 0; base < all; base += 32) {
        const int at = base + lane;
        int owner = 0;  // the first lane with up_to > at
        UNROLL
        for (int step = 16; step > 0; step /= 2)
            if (__shfl_sync(~0u, up_to, owner + step - 1) <= at) owner += step;
        const bool in = at < all;
        const Candidates c = from_lane(mine, owner);
        const int local = at - (__shfl_sync(~0u, up_to, owner) - c.all);
        const int e = local >= c.left ? 1 : 0, n = local - e * c.left;
        const TileBox box = c.boxes.eye[e];
        const int columns = max(int(box.columns), 1), row = n / columns;
        const int x = int(box.x) + n - row * columns, y = int(box.y) + row;
        const int record = e * d.splats.count + c.splat;
        const float x0 = float(x * tile_size), y0 = float(y * tile_size);
        const bool reached = in && reaches(shape_of(d, in ? record : 0), x0, y0,
                                           x0 + (tile_size - 1), y0 + (tile_size - 1));
        use(reached, (e * d.rows + y) * d.columns + x, record);
    }
}

__global__ void __launch_bounds__(threads) count_kernel(const __grid_constant__ RasterView d)
{
    const int rank = int(blockIdx.x) * threads + int(threadIdx.x), group = rank / 32;
    if (group > d.groups) return;
    const Candidates mine = candidates_of(d, rank);
    unsigned count = 0;
    each_candidate(d, mine, [&](bool reached, int, int) {
        count += unsigned(__popc(__ballot_sync(~0u, reached)));
    });
    if (rank % 32 == 0) d.group_counts[group] = count;
    const auto seen = [&](int k) { return k < d.splats.count && d.sorted_keys[k] != no_depth_key; };
    if (mine.all > 0 && !seen(rank + 1)) d.counts->visible = unsigned(rank) + 1;
}

__global__ void __launch_bounds__(threads) emit_kernel(const __grid_constant__ RasterView d)
{
    const int rank = int(blockIdx.x) * threads + int(threadIdx.x), group = rank / 32;
    const unsigned long long total = d.group_starts[d.groups], room = unsigned(d.room);
    if (rank == 0) {
        d.counts->instances = total;
        d.counts->dropped = total > room ? total - room : 0;
    }
    if (group >= d.groups) return;
    unsigned long long at = d.group_starts[group];
    if (at >= room || at == d.group_starts[group + 1]) return;
    const unsigned before = (1u << (rank % 32)) - 1;
    each_candidate(d, candidates_of(d, rank), [&](bool reached, int tile, int record) {
        const unsigned all = __ballot_sync(~0u, reached);
        const unsigned long long mine = at + unsigned(__popc(all & before));
        if (reached && mine < room)
            d.tiles[0][mine] = std::uint16_t(tile), d.records[0][mine] = record;
        at += unsigned(__popc(all));
    });
}

__global__ void __launch_bounds__(threads) range_kernel(const __grid_constant__ RasterView d)
{
    const int count = int(min(d.group_starts[d.groups], (unsigned long long)d.room));
    const int i = int(blockIdx.x) * threads + int(threadIdx.x);
    if (i >= count) return;
    const int tile = d.tiles[0][i];
    if (i == 0 || d.tiles[0][i - 1] != tile) d.ranges[tile].x = unsigned(i);
    if (i == count - 1 || d.tiles[0][i + 1] != tile) d.ranges[tile].y = unsigned(i) + 1;
}

}  // namespace

std::size_t raster_scratch_bytes(int splats, int groups)
{
    RasterView d{};
    d.splats.count = splats, d.groups = groups;
    std::size_t depth = 0, scan = 0;
    check(depth_sort(d, nullptr, depth, nullptr), "sort");
    check(group_scan(d, nullptr, scan, nullptr), "scan");
    return max(tile_sort_scratch_bytes(), max(depth, scan));
}

void sort_by_depth(const RasterView& view, const RasterScratch& s, cudaStream_t stream)
{
    const ProfilerRange range{"sort"};
    std::size_t bytes = s.bytes;
    check(depth_sort(view, s.memory, bytes, stream), "sort");
}

void count_tiles(const RasterView& view, cudaStream_t stream)
{
    check(cudaMemsetAsync(view.counts, 0, sizeof *view.counts, stream), "count");
    launch("count", count_kernel, blocks_for(32 * (view.groups + 1), threads), threads, stream,
           view);
}

void scan_counts(const RasterView& view, const RasterScratch& s, cudaStream_t stream)
{
    const ProfilerRange range{"scan"};
    std::size_t bytes = s.bytes;
    check(group_scan(view, s.memory, bytes, stream), "scan");
}

void emit(const RasterView& view, cudaStream_t stream)
{
    launch("emit", emit_kernel, blocks_for(32 * view.groups, threads), threads, stream, view);
}

void find_ranges(const RasterView& view, cudaStream_t stream)
{
    check(cudaMemsetAsync(view.ranges, 0, std::size_t(view.all_tiles()) * sizeof *view.ranges,
                          stream),
          "ranges");
    launch("ranges", range_kernel, blocks_for(view.room, threads), threads, stream, view);
}

}  // namespace knead::gpu
