// Particles to density. A block of threads sums its particles, which are neighbours since the last
// sort, in shared memory, and hands on one sum per node.
#include <thrust/iterator/counting_iterator.h>

#include <climits>
#include <cub/device/device_select.cuh>

#include "density.h"
#include "launch.cuh"
#include "surface.cuh"

namespace knead::gpu {
namespace {

constexpr int clear_threads = 64, splat_threads = 256, soften_threads = 128;
constexpr int box_nodes = 6144;  // of shared memory; particles strewn wider add to memory directly
constexpr Int3 one{1, 1, 1};

__global__ void __launch_bounds__(clear_threads) clear_kernel(const __grid_constant__ SurfaceView d)
{
    const int t = int(threadIdx.x), row = t / 16, quarter = t % 16;
    if (blockIdx.x == 0 && t == 0) *d.faults = {};
    const auto emptied = [&](int block, auto* nodes) {
        reinterpret_cast<uint4*>(nodes + std::size_t(block) * block_nodes)[quarter] = {};
    };
    for (int k = int(blockIdx.x); k < *d.active; k += int(gridDim.x)) {
        const int block = d.list[k];
        if (row == 0) emptied(block, d.sums);
        if (row == 1) emptied(block, d.density[0]);
        if (row == 2) emptied(block, d.density[1]);
        if (row == 3) emptied(block, d.marks);
        if (t == 0) d.touched[block] = 0, d.counts[block] = 0;
    }
}

// Particle i, if it is one that a surface shows.
__device__ bool taken(const SurfaceView& d, const ParticleView& particles, int i, Vec3<float>& x,
                      Grain& grain)
{
    if (i >= particles.count) return false;
    const Particle<float> q = particles.load(i);
    x = q.x;
    grain = q.object >= 0 && q.object < d.grains.count ? d.grains[q.object] : Grain{0, 0};
    if (!(grain.units > 0) || !isfinite(x.x) || !isfinite(x.y) || !isfinite(x.z)) {
        atomicAdd(&d.faults->unusable, 1u);
        return false;
    }
    if (inside(x, d.lattice)) return true;
    atomicAdd(&d.faults->outside, 1u);
    return false;
}

__device__ void add_to_memory(const SurfaceView& d, int category, Int3 node, unsigned amount)
{
    if (amount == 0) return;
    const int i = category * d.layer_nodes() + d.padded.index(node + one);
    const unsigned before = atomicAdd(&d.sums[i], amount);
    if (before == 0) d.touched[i / block_nodes] = 1;
    if (before + amount < before) d.faults->crowded = 1;
}

// The nodes that the particles of one category in this block of threads reach.
struct Box {
    int category, low[3], high[3];
    __device__ Int3 size() const
    {
        return {high[0] - low[0] + 3, high[1] - low[1] + 3, high[2] - low[2] + 3};
    }
};

// All threads of the block; `mine` is whether the thread has a particle.
__device__ void enclose(Box& box, bool mine, int category, Int3 base)
{
    const int t = int(threadIdx.x);
    if (t < 3) box.low[t] = INT_MAX, box.high[t] = INT_MIN;
    if (t == 3) box.category = INT_MAX;
    __syncthreads();
    const int least_category = __reduce_min_sync(~0u, mine ? category : INT_MAX);
    if (t % 32 == 0) atomicMin(&box.category, least_category);
    __syncthreads();
    const bool in = mine && category == box.category;
    const auto widen = [&](int axis, int n) {
        const int low = __reduce_min_sync(~0u, in ? n : INT_MAX);
        const int high = __reduce_max_sync(~0u, in ? n : INT_MIN);
        if (t % 32 == 0) atomicMin(&box.low[axis], low), atomicMax(&box.high[axis], high);
    };
    widen(0, base.x), widen(1, base.y), widen(2, base.z);
    __syncthreads();
}

__global__ void __launch_bounds__(splat_threads)
    splat_kernel(const __grid_constant__ SurfaceView d, const __grid_constant__ Clay clay)
{
    __shared__ unsigned sums[box_nodes];
    __shared__ Box box;
    const int t = int(threadIdx.x), i = int(blockIdx.x) * splat_threads + t;
    Vec3<float> x{};
    Grain grain{};
    const bool mine = taken(d, clay.particles[clay.side ? *clay.side : 0], i, x, grain);
    const Stencil<float> s = stencil(x, d.lattice.dx);
    enclose(box, mine, grain.category, s.base);
    if (box.category == INT_MAX) return;
    const Int3 low{box.low[0], box.low[1], box.low[2]}, size = box.size();
    const bool shared = float(size.x) * float(size.y) * float(size.z) <= float(box_nodes);
    const int nodes = shared ? size.x * size.y * size.z : 0;
    for (int k = t; k < nodes; k += splat_threads) sums[k] = 0;
    __syncthreads();
    if (mine && shared && grain.category == box.category) {
        const Int3 from = s.base - low;
        unsigned* const base = sums + (from.z * size.y + from.y) * size.x + from.x;
        deposit(s, grain.units, [&](Int3 step, float part) {
            atomicAdd(base + (step.z * size.y + step.y) * size.x + step.x, __float2uint_rn(part));
        });
    } else if (mine) {
        deposit(s, grain.units, [&](Int3 step, float part) {
            add_to_memory(d, grain.category, s.base + step, __float2uint_rn(part));
        });
    }
    __syncthreads();
    for (int k = t; k < nodes; k += splat_threads)
        add_to_memory(d, box.category,
                      low + Int3{k % size.x, k / size.x % size.y, k / (size.x * size.y)}, sums[k]);
}

// Whether a block holds density after all softening, or cells beside such: a pass moves density by
// a node, and a cell belongs to its lowest.
struct Reached {
    SurfaceView d;
    __device__ bool operator()(int b) const
    {
        const int category = b / d.layer_blocks(), first = category * d.layer_blocks();
        const Int3 at = d.padded.block_at(b - first), size = d.padded.blocks();
        const int reach = (d.layers[category].softenings + block_edge) / block_edge;
        for (int z = most(at.z - reach, 0); z <= least(at.z + reach, size.z - 1); ++z)
            for (int y = most(at.y - reach, 0); y <= least(at.y + reach, size.y - 1); ++y)
                for (int x = most(at.x - reach, 0); x <= least(at.x + reach, size.x - 1); ++x)
                    if (d.touched[first + (z * size.y + y) * size.x + x]) return true;
        return false;
    }
};

cudaError_t select(const SurfaceView& d, void* scratch, std::size_t& bytes, cudaStream_t stream)
{
    return cub::DeviceSelect::If(scratch, bytes, thrust::counting_iterator<int>(0), d.list,
                                 d.active, d.blocks, Reached{d}, stream);
}

constexpr int halo = passes_a_round, tile_edge = block_edge + 2 * halo,
              tile_nodes = tile_edge * tile_edge * tile_edge;

// Node t of the tile around a block.
__device__ Int3 tile_node(const SurfaceView& d, int block, int t)
{
    const Int3 local{t % tile_edge, t / tile_edge % tile_edge, t / (tile_edge * tile_edge)};
    return block_edge * d.padded.block_at(block) + local - halo * one;
}
__device__ bool within(Int3 n, Int3 size)
{
    return n.x >= 0 && n.y >= 0 && n.z >= 0 && n.x < size.x && n.y < size.y && n.z < size.z;
}
__device__ bool at_rim(int along) { return along == 0 || along == tile_edge - 1; }

// Softens a tile in place of itself or `other`: what lies at its rim is lost, by a node a pass.
// Nodes outside of the lattice stay empty, as if the density went on for ever.
__device__ float* softened_tile(const SurfaceView& d, int block, int passes, float* tile,
                                float* other)
{
    for (int sweep = 0; sweep < 3 * passes; ++sweep) {
        const int axis = sweep % 3;
        const int stride = axis == 0 ? 1 : axis == 1 ? tile_edge : tile_edge * tile_edge;
        for (int t = int(threadIdx.x); t < tile_nodes; t += soften_threads) {
            const bool open = !at_rim(t / stride % tile_edge) &&
                              within(tile_node(d, block, t) - one, d.lattice.size);
            other[t] =
                open ? softened<float>([&](int step) { return tile[t + step * stride]; }) : 0;
        }
        __syncthreads();
        float* const now = other;
        other = tile, tile = now;
    }
    return tile;
}

__global__ void __launch_bounds__(soften_threads)
    soften_kernel(const __grid_constant__ SurfaceView d, int round)
{
    __shared__ float tiles[2][tile_nodes];
    for (int k = int(blockIdx.x); k < *d.active; k += int(gridDim.x)) {
        const int category = d.list[k] / d.layer_blocks();
        const int first = category * d.layer_nodes();
        const int block = d.list[k] - category * d.layer_blocks();
        const Layer layer = d.layers[category];
        const unsigned* const sums = d.sums + first;
        const float* const from = d.density[(round & 1) ^ 1] + first;
        for (int t = int(threadIdx.x); t < tile_nodes; t += soften_threads) {
            const Int3 n = tile_node(d, block, t);
            float value = 0;
            if (within(n, d.padded.size)) {
                const int i = d.padded.index(n);
                value = round == 0 ? layer.quantum * float(sums[i]) : from[i];
            }
            tiles[0][t] = value;
        }
        __syncthreads();
        const int passes = clamped(layer.softenings - round * halo, 0, halo);
        const float* const tile = softened_tile(d, block, passes, tiles[0], tiles[1]);
        for (int t = int(threadIdx.x); t < block_nodes; t += soften_threads)
            d.density[round & 1][first + block * block_nodes + t] =
                tile[((t / 16 + halo) * tile_edge + t / 4 % 4 + halo) * tile_edge + t % 4 + halo];
        __syncthreads();
    }
}

}  // namespace

std::size_t list_scratch_bytes(int blocks)
{
    std::size_t bytes = 0;
    SurfaceView d{};
    d.blocks = blocks;
    check(select(d, nullptr, bytes, nullptr), "list");
    return bytes;
}

void clear(const SurfaceView& view, int processors, cudaStream_t stream)
{
    launch("surface clear", clear_kernel, least(view.blocks, 16 * processors), clear_threads,
           stream, view);
}

void splat(const SurfaceView& view, const Clay& clay, cudaStream_t stream)
{
    launch("surface splat", splat_kernel, blocks_for(clay.particles[0].count, splat_threads),
           splat_threads, stream, view, clay);
}

void list(const SurfaceView& view, const ScanSpace& space, cudaStream_t stream)
{
    const ProfilerRange range{"surface list"};
    std::size_t bytes = space.bytes;
    check(select(view, space.scratch, bytes, stream), "surface list");
}

void soften(const SurfaceView& view, int round, int processors, cudaStream_t stream)
{
    launch("surface soften", soften_kernel, least(view.blocks, 16 * processors), soften_threads,
           stream, view, round);
}

}  // namespace knead::gpu
