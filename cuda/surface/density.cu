// Particles to density. A warp sums its particles, which are neighbours since the last sort, in
// shared memory, and adds one sum per node to global memory.
#include <climits>

#include "cuda/device/launch.cuh"
#include "cuda/surface/density.h"
#include "cuda/surface/surface.cuh"

namespace knead::gpu {
namespace {

constexpr int clear_threads = 64, deposit_threads = 128, list_threads = 128, smooth_threads = 128;
constexpr int box_nodes = 1024;  // of a warp; wider ones add to global memory singly
constexpr Int3 one{1, 1, 1};

__global__ void __launch_bounds__(clear_threads) clear_kernel(const __grid_constant__ SurfaceView d)
{
    wait_upstream_and_trigger();
    const int t = int(threadIdx.x), row = t / 16, quarter = t % 16;
    if (unchanged(d)) return;
    if (blockIdx.x == 0 && t == 0) *d.errors = {}, d.active[0] = d.active[1] = 0;
    if (blockIdx.x == 0 && t == 0 && d.whole) *d.progress = {};
    const auto emptied = [&](int block, auto* nodes) {
        reinterpret_cast<uint4*>(nodes + std::size_t(block) * block_nodes)[quarter] = {};
    };
    for (int k = int(blockIdx.x); k < d.active[2]; k += int(gridDim.x)) {
        const int block = d.list[k];
        const unsigned dirty = dirty_of(d, block % d.layer_blocks());
        if (!(dirty & nodes_dirty)) continue;
        if (row == 0 && (dirty & sums_dirty)) emptied(block, d.sums);
        if (row == 1) emptied(block, d.marks);
        for (int round = row - 2; row > 1 && round < d.rounds; round += 2)
            emptied(block, d.density_of(round));
        if (t == 0) d.counts[block] = 0;
        if (t == 0 && (dirty & sums_dirty)) d.occupied[block] = 0;
    }
}

// Loads particle i; returns whether it is part of a surface.
__device__ bool taken(const SurfaceView& d, const ParticleView& particles, int i, Vec3<float>& x,
                      ObjectDeposit& object_deposit)
{
    if (i >= particles.count) return false;
    const Particle<float> q = particles.load(i);
    x = q.x;
    object_deposit = d.first;
    if (q.object != 0) object_deposit = {0, 0};
    if (q.object > 0 && q.object < d.object_deposits.count)
        object_deposit = d.object_deposits[q.object];
    if (!(object_deposit.units > 0) || !isfinite(x.x) || !isfinite(x.y) || !isfinite(x.z)) {
        atomicAdd(&d.errors->unusable, 1u);
        return false;
    }
    if (inside(x, d.lattice)) return true;
    atomicAdd(&d.errors->outside, 1u);
    return false;
}

// A warp's particles of one category, and the bounding box of their nodes.
struct NodeBox {
    int category;  // INT_MAX: no particle
    Int3 low, size;
    int nodes;  // 0: too many for shared memory
};

// Warp-collective; `mine`: the lane has a particle.
__device__ NodeBox enclosing(bool mine, int category, Int3 base)
{
    NodeBox box{__reduce_min_sync(~0u, mine ? category : INT_MAX), {}, {}, 0};
    const bool in = mine && category == box.category;
    const auto lowest = [in](int n) { return __reduce_min_sync(~0u, in ? n : INT_MAX); };
    const auto highest = [in](int n) { return __reduce_max_sync(~0u, in ? n : INT_MIN); };
    box.low = {lowest(base.x), lowest(base.y), lowest(base.z)};
    const Int3 high{highest(base.x), highest(base.y), highest(base.z)};
    if (box.category == INT_MAX) return box;
    box.size = high - box.low + 3 * one;
    const float nodes = float(box.size.x) * float(box.size.y) * float(box.size.z);
    if (nodes <= float(box_nodes)) box.nodes = box.size.x * box.size.y * box.size.z;
    return box;
}

// Adds a warp's sums to global memory, a few nodes per lane at a time: their latencies overlap.
template <bool incremental>
__device__ void hand_on(const SurfaceView& d, const NodeBox& box, const unsigned* sums, int lane)
{
    constexpr int at_once = 5;
    const int layer = box.category * d.layer_nodes();
    // Division of small integers by multiplication: halves are far from the next integer.
    const float by_x = 1 / float(box.size.x), by_y = 1 / float(box.size.y);
    for (int k = lane; k < box.nodes; k += 32 * at_once) {
        unsigned amount[at_once], before[at_once];
        int at[at_once];
        UNROLL
        for (int j = 0; j < at_once; ++j) {
            const int n = k + 32 * j, row = int((float(n) + 0.5f) * by_x),
                      z = int((float(row) + 0.5f) * by_y);
            const Int3 local{n - row * box.size.x, row - z * box.size.y, z};
            amount[j] = n < box.nodes ? sums[n] : 0;
            at[j] = layer + d.padded.index(box.low + local + one);
        }
        if constexpr (incremental) {
            UNROLL
            for (int j = 0; j < at_once; ++j)
                if (amount[j] && !(d.dirty[(at[j] - layer) / block_nodes] & sums_dirty))
                    amount[j] = 0;
        }
        UNROLL
        for (int j = 0; j < at_once; ++j)
            before[j] = amount[j] ? atomicAdd(&d.sums[at[j]], amount[j]) : 1;
        UNROLL
        for (int j = 0; j < at_once; ++j) {
            if (before[j] == 0) d.occupied[at[j] / block_nodes] = 1;
            if (before[j] + amount[j] < before[j]) d.errors->overflowed = 1;
        }
    }
}

// One particle by itself. A sum counts as overflowed before the end of its range, so none wraps
// undetected.
template <bool incremental>
__device__ void add_alone(const SurfaceView& d, const Stencil<float>& s,
                          const ObjectDeposit& object_deposit)
{
    const int layer = object_deposit.category * d.layer_nodes();
    unsigned fullest = 0;
    deposit(s, object_deposit.units, [&](Int3 step, float part) {
        const int node = d.padded.index(s.base + step + one), at = layer + node;
        if (incremental && !(d.dirty[node / block_nodes] & sums_dirty)) return;
        fullest = max(fullest, atomicAdd(&d.sums[at], __float2uint_rn(part)));
        if (step.x != 1 && step.y != 1 && step.z != 1) d.occupied[at / block_nodes] = 1;
    });
    if (fullest >> 31) d.errors->overflowed = 1;
}

// `incremental`: only particles that reach a recomputed block, and only such blocks.
template <bool incremental>
__global__ void __launch_bounds__(deposit_threads)
    deposit_kernel(const __grid_constant__ SurfaceView d, const __grid_constant__ Clay clay)
{
    __shared__ unsigned boxes[deposit_threads / 32][box_nodes];
    wait_upstream_and_trigger();
    const int t = int(threadIdx.x), i = int(blockIdx.x) * deposit_threads + t, lane = t % 32;
    unsigned* const sums = boxes[t / 32];
    if (incremental && i == 0) *d.last_substep = *clay.substeps;
    if (incremental && unchanged(d)) return;
    Vec3<float> x{};
    ObjectDeposit object_deposit{};
    bool mine = taken(d, clay.particles[clay.side ? *clay.side : 0], i, x, object_deposit);
    const Stencil<float> s = stencil(x, d.lattice.dx);
    if (incremental && mine) mine = (d.dirty[d.padded.block_of(s.base + one)] & near_dirty) != 0;
    if (incremental && !__any_sync(~0u, mine)) return;
    const NodeBox box = enclosing(mine, object_deposit.category, s.base);
    for (int k = lane; k < box.nodes; k += 32) sums[k] = 0;
    __syncwarp();
    if (mine && box.nodes && object_deposit.category == box.category) {
        const Int3 from = s.base - box.low;
        unsigned* const base = sums + (from.z * box.size.y + from.y) * box.size.x + from.x;
        deposit(s, object_deposit.units, [&](Int3 step, float part) {
            atomicAdd(base + (step.z * box.size.y + step.y) * box.size.x + step.x,
                      __float2uint_rn(part));
        });
    } else if (mine) {
        add_alone<incremental>(d, s, object_deposit);
    }
    __syncwarp();
    hand_on<incremental>(d, box, sums, lane);
}

// Appends the blocks of lanes with `in` to a list of at most `room`. Warp-collective.
__device__ void append(int* list, int room, int* count, int block, bool in)
{
    const int lane = int(threadIdx.x) % 32;
    const unsigned all = __ballot_sync(~0u, in);
    int first = 0;
    if (lane == 0 && all) first = atomicAdd(count, __popc(all));
    first = __shfl_sync(~0u, first, 0) + __popc(all & ((1u << lane) - 1));
    if (in && first < room) list[first] = block;
}

// Lists a thread's block if it has density after all smoothing, or cells next to such: a pass
// spreads density by one node, and a cell belongs to its lowest node.
__global__ void __launch_bounds__(list_threads) list_kernel(const __grid_constant__ SurfaceView d)
{
    wait_upstream_and_trigger();
    if (unchanged(d)) return;
    const int b = int(blockIdx.x) * list_threads + int(threadIdx.x);
    unsigned reached = 0, dirty = 0;
    bool skin = false;
    if (b < d.blocks) {
        const int category = b / d.layer_blocks(), first = category * d.layer_blocks();
        const Int3 at = d.padded.block_at(b - first), size = d.padded.blocks();
        const int reach = (d.scales[category].smoothing_passes + block_edge) / block_edge;
        for (int z = max(at.z - reach, 0); z <= min(at.z + reach, size.z - 1); ++z)
            for (int y = max(at.y - reach, 0); y <= min(at.y + reach, size.y - 1); ++y)
                for (int x = max(at.x - reach, 0); x <= min(at.x + reach, size.x - 1); ++x)
                    reached |= d.occupied[first + d.padded.block_of({4 * x, 4 * y, 4 * z})];
        dirty = reached ? dirty_of(d, b - first) : 0;
        skin = reached && !(dirty & nodes_dirty) && d.counts[b] != 0;
    }
    append(d.list, d.blocks, d.active, b, reached != 0);
    append(d.skin, d.blocks, d.active + 1, b, skin);
    append(d.work, d.blocks, &d.progress->smoothed, b, (dirty & nodes_dirty) != 0);
    const unsigned deposited = __ballot_sync(~0u, (dirty & sums_dirty) != 0);
    if (threadIdx.x % 32 == 0 && deposited) atomicAdd(&d.progress->deposited, __popc(deposited));
}

// The nodes around a block, in the registers of a warp: a lane has one x, two adjacent y and all z,
// so that passes need no memory.
constexpr int halo = passes_a_round, tile_edge = block_edge + 2 * halo;
static_assert(tile_edge == 8);
struct Tile {
    float v[2][tile_edge];  // y, z
};

// Calls visit(j, z) for the lane's nodes except those less than `rim` from either end in z.
template <int rim, class Visit>
__device__ void for_each_of(Visit&& visit)
{
    UNROLL
    for (int n = 2 * rim; n < 2 * (tile_edge - rim); ++n) visit(n % 2, n / 2);
}

// One pass along every axis for nodes at least `rim` from the tile's ends; a pass loses one node at
// every end. Bit 2 * z + j of `open`: the lane's node is on the lattice; others stay empty, as if
// the lattice were infinite.
template <int rim>
__device__ void smooth_tile(Tile& t, int lane, unsigned open)
{
    const auto from_lane = [&](float v, int step) { return __shfl_sync(~0u, v, lane + step); };
    const auto along = [&](auto value, auto each) {
        Tile to = t;
        each([&](int j, int z) {
            to.v[j][z] = smoothed<float>([&](int step) { return value(j, z, step); });
        });
        t = to;
    };
    const auto all = [](auto visit) { for_each_of<rim>(visit); };
    const auto inner = [](auto visit) { for_each_of<rim + 1>(visit); };
    const auto close = [&] {
        if (__all_sync(~0u, open == ~0u >> (32 - 2 * tile_edge))) return;
        all([&](int j, int z) {
            if (!(open >> (2 * z + j) & 1)) t.v[j][z] = 0;
        });
    };
    along([&](int j, int z, int step) { return step ? from_lane(t.v[j][z], step) : t.v[j][z]; },
          all);
    close();
    along(
        [&](int j, int z, int step) {
            if (step == 0) return t.v[j][z];
            return (step > 0) == (j == 0) ? t.v[j ^ 1][z]
                                          : from_lane(t.v[j ^ 1][z], step * tile_edge);
        },
        all);
    close();
    along([&](int j, int z, int step) { return t.v[j][z + step]; }, inner);
    close();
}

__global__ void __launch_bounds__(smooth_threads)
    soften_kernel(const __grid_constant__ SurfaceView d, int round)
{
    constexpr int warps = smooth_threads / 32;
    static_assert(passes_a_round == 2);
    wait_upstream_and_trigger();
    const int lane = int(threadIdx.x) % 32, warp = int(threadIdx.x) / 32;
    const Int3 corner{lane % tile_edge, 2 * (lane / tile_edge), 0};  // the lane's first node
    const int blocks = d.progress->smoothed;
    for (int k = int(blockIdx.x) * warps + warp; k < blocks; k += int(gridDim.x) * warps) {
        const int block = d.work[k], category = block / d.layer_blocks();
        const int first = category * d.layer_nodes();
        const CategoryScale scale = d.scales[category];
        const Int3 low = block_edge * d.padded.block_at(block - category * d.layer_blocks()) -
                         halo * one + corner;
        const unsigned* const sums = d.sums + first;
        const float* const from = d.density_of(max(round - 1, 0)) + first;
        Tile tile;
        unsigned open = 0;
        for_each_of<0>([&](int j, int z) {
            const Int3 n = low + Int3{0, j, z};
            tile.v[j][z] = 0;
            if (within(n - one, d.lattice.size)) {
                const int i = d.padded.index(n);
                tile.v[j][z] = round == 0 ? scale.quantum * float(sums[i]) : from[i];
                open |= 1u << (2 * z + j);
            }
        });
        const int passes = scale.smoothing_passes - round * halo;
        if (passes > 0) smooth_tile<0>(tile, lane, open);
        if (passes > 1) smooth_tile<1>(tile, lane, open);
        float* const to = d.density_of(round) + std::size_t(block) * block_nodes;
        const Int3 at = corner - halo * one;
        for_each_of<halo>([&](int j, int z) {
            const Int3 n = at + Int3{0, j, z};
            if (within(n, block_edge * one)) to[(n.z * 4 + n.y) * 4 + n.x] = tile.v[j][z];
        });
    }
}

}  // namespace

void clear(const SurfaceView& view, int processors, cudaStream_t stream)
{
    launch_pdl("surface clear", clear_kernel, min(view.blocks, 16 * processors), clear_threads,
               stream, view);
}

void deposit(const SurfaceView& view, const Clay& clay, cudaStream_t stream)
{
    launch_pdl("surface deposit", view.whole ? deposit_kernel<false> : deposit_kernel<true>,
               blocks_for(clay.particles[0].count, deposit_threads), deposit_threads, stream, view,
               clay);
}

void list(const SurfaceView& view, cudaStream_t stream)
{
    launch_pdl("surface list", list_kernel, blocks_for(view.blocks, list_threads), list_threads,
               stream, view);
}

void smooth_density(const SurfaceView& view, int round, int processors, cudaStream_t stream)
{
    launch_pdl("surface soften", soften_kernel,
               min(blocks_for(view.blocks, smooth_threads / 32), 16 * processors), smooth_threads,
               stream, view, round);
}

}  // namespace knead::gpu
