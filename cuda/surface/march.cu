// Density to triangles with shared vertices: count per block, scan over blocks, write. Indices of
// vertices and triangles depend on their position only, so they are the same in every run.
#include <cstddef>
#include <cub/device/device_scan.cuh>

#include "cuda/device/launch.cuh"
#include "cuda/surface/march.h"
#include "cuda/surface/surface.cuh"

namespace knead::gpu {
namespace {

constexpr int count_threads = 128, march_threads = 128, warps = count_threads / 32;
constexpr int cell_edge = block_edge + 1, cell_nodes = cell_edge * cell_edge * cell_edge;
constexpr int tile_edge = block_edge + 2, tile_nodes = tile_edge * tile_edge * tile_edge;
constexpr Int3 one{1, 1, 1};

alignas(unsigned)
    __device__ const MarchTable table = march_table;  // copied to where it is read often

// Marching-cubes data of a node: the edges crossed, its first vertex and its cell's first triangle
// within the block, its cell's case.
struct Mark {
    unsigned bits;
    __device__ static Mark of(unsigned crossed, int vertex, int inside, int triangle)
    {
        return {crossed | unsigned(vertex) << 3 | unsigned(inside) << 11 |
                unsigned(triangle) << 19};
    }
    __device__ unsigned crossed() const { return bits & 7; }
    __device__ int vertex() const { return int(bits >> 3 & 255); }
    __device__ int inside() const { return int(bits >> 11 & 255); }
    __device__ int triangle() const { return int(bits >> 19); }
};

__device__ int cell_node(int x, int y, int z) { return (z * cell_edge + y) * cell_edge + x; }

// A node's crossed edges and its cell's case and number of triangles.
struct Cell {
    unsigned crossed;
    int inside, triangles;
};
__device__ Cell cell_of(const float* tile, int l, float iso)
{
    const float* const v = tile + cell_node(l % 4, l / 4 % 4, l / 16);
    const unsigned crossed = crossed_edges(
        *v, iso, [&](int axis) { return v[cell_node(axis == 0, axis == 1, axis == 2)]; });
    const int inside =
        cell_case(iso, [&](int c) { return v[cell_node(c & 1, c >> 1 & 1, c >> 2)]; });
    return {crossed, inside, table.count[inside]};
}

// Number of vertices of lower lanes.
__device__ int vertices_before(unsigned crossed, unsigned lanes)
{
    int sum = 0;
    UNROLL
    for (int axis = 0; axis < 3; ++axis)
        sum += __popc(__ballot_sync(~0u, crossed >> axis & 1) & lanes);
    return sum;
}

__device__ int sum_up_to(int value, int lane)
{
    UNROLL
    for (int step = 1; step < 32; step *= 2) {
        const int other = __shfl_up_sync(~0u, value, unsigned(step));
        value += lane >= step ? other : 0;
    }
    return value;
}

// Position of a block: its category's first node, and its own lowest node.
struct Place {
    int first;
    Int3 low;
    __device__ Place(const SurfaceView& d, int block)
    {
        const int category = block / d.layer_blocks();
        first = category * d.layer_nodes();
        low = block_edge * d.padded.block_at(block - category * d.layer_blocks());
    }
};

// Loads the nodes of a block's cells, by a warp; returns whether the surface passes between any
// two.
__device__ bool passed(const SurfaceView& d, int block, float* tile, int lane)
{
    const Place p(d, block);
    const float* const density = d.final_density();
    bool some_in = false, some_out = false;
    UNROLL
    for (int t = lane; t < cell_nodes; t += 32) {
        const Int3 n = p.low + Int3{t % cell_edge, t / cell_edge % cell_edge, t / 25};
        const float v = within(n, d.padded.size) ? density[p.first + d.padded.index(n)] : 0;
        (is_inside(v, d.iso) ? some_in : some_out) = true;
        tile[t] = v;
    }
    return __any_sync(~0u, some_in) && __any_sync(~0u, some_out);
}

// One warp per block of the lattice: a lane has nodes `lane` and `lane` + 32.
__global__ void __launch_bounds__(count_threads) count_kernel(const __grid_constant__ SurfaceView d)
{
    __shared__ float tiles[warps][cell_nodes];
    wait_upstream_and_trigger();
    const int lane = int(threadIdx.x) % 32, warp = int(threadIdx.x) / 32;
    float* const tile = tiles[warp];
    const int blocks = d.progress->smoothed;
    for (int k = int(blockIdx.x) * warps + warp; k < blocks; k += int(gridDim.x) * warps) {
        const int block = d.work[k];
        unsigned* const marks = d.marks + std::size_t(block) * block_nodes;
        if (!passed(d, block, tile, lane)) {
            marks[lane] = marks[lane + 32] = 0;
            if (lane == 0) d.counts[block] = 0;
            continue;
        }
        __syncwarp();
        const Cell a = cell_of(tile, lane, d.iso), b = cell_of(tile, lane + 32, d.iso);
        const unsigned lanes = (1u << lane) - 1;
        const int vertex = vertices_before(a.crossed, lanes),
                  vertices = vertices_before(a.crossed, ~0u);
        const int triangle = sum_up_to(a.triangles | b.triangles << 16, lane);
        const int sums = __shfl_sync(~0u, triangle, 31), triangles = sums & 0xffff;
        marks[lane] = Mark::of(a.crossed, vertex, a.inside, (triangle & 0xffff) - a.triangles).bits;
        marks[lane + 32] = Mark::of(b.crossed, vertices + vertices_before(b.crossed, lanes),
                                    b.inside, triangles + (triangle >> 16) - b.triangles)
                               .bits;
        const int all = vertices + vertices_before(b.crossed, ~0u);
        const auto both = unsigned(all) | static_cast<unsigned long long>(triangles + (sums >> 16))
                                              << 32;
        if (lane == 0) {
            d.counts[block] = both;
            const int place = both ? atomicAdd(&d.active[1], 1) : d.blocks;
            if (place < d.blocks) d.skin[place] = block;
        }
        __syncwarp();
    }
}

__device__ int tile_step(int corner)
{
    return (corner & 1) + (corner >> 1 & 1) * tile_edge + (corner >> 2) * tile_edge * tile_edge;
}
// Index of node l of the block in a tile with a layer around the block.
__device__ int tile_at(int l)
{
    return tile_step(7) + l % 4 + (l / 4 % 4 + l / 16 * tile_edge) * tile_edge;
}

__device__ void copy(const MarchTable& from, MarchTable& to)
{
    static_assert(offsetof(MarchTable, sound) % sizeof(unsigned) == 0);
    constexpr int words = int(offsetof(MarchTable, sound) / sizeof(unsigned));
    for (int t = int(threadIdx.x); t < words; t += march_threads)
        reinterpret_cast<unsigned*>(&to)[t] = reinterpret_cast<const unsigned*>(&from)[t];
}

// Vertex indices in and around a block, by node.
struct Names {
    unsigned marks[tile_nodes];
    int first[tile_nodes];
    __device__ int first_of(int node, int axis) const
    {
        return first[node] + rank_of(Mark{marks[node]}.crossed(), axis);
    }
    __device__ int vertex(int cell, int e) const
    {
        return first_of(cell + tile_step(low_corner(e)), e / 4);
    }
};

__device__ void name(const SurfaceView& d, const Place& p, Names& names)
{
    for (int t = int(threadIdx.x); t < tile_nodes; t += march_threads) {
        const Int3 n = p.low + Int3{t % tile_edge, t / tile_edge % tile_edge, t / 36} - one;
        unsigned mark = 0, before = 0;
        if (within(n, d.padded.size)) {
            const int i = p.first + d.padded.index(n);
            mark = d.marks[i], before = unpacked(d.before[i / block_nodes]).vertices;
        }
        names.marks[t] = mark;
        names.first[t] = int(before) + Mark{mark}.vertex();
    }
}

// The vertex on the edge of node l along an axis.
__device__ void place(const SurfaceView& d, const Place& p, int v, int l, int axis, int to)
{
    const Int3 n = p.low + Int3{l % 4, l / 4 % 4, l / 16};
    const Int3 end = n + Int3{axis == 0, axis == 1, axis == 2};
    const float* const density = d.final_density() + p.first;
    const float low = density[d.padded.index(n)],
                high = within(end, d.padded.size) ? density[d.padded.index(end)] : 0;
    const Vec3<float> x = crossing_point(n - one, axis, crossing(low, high, d.iso), d.lattice.dx);
    d.vertices[to][v] = {x.x, x.y, x.z, 1};
}

// The ring of a vertex of the block, by four lanes, each with the triangles of one cell; `lanes` is
// their mask.
__device__ void find_ring(const SurfaceView& d, const Names& names, const MarchTable& cases, int v,
                          int l, int axis, int k, unsigned lanes)
{
    const int cell = tile_at(l) - tile_step(corner_of_cell(axis, k)), e = edge_of_cell(axis, k);
    const int inside = Mark{names.marks[cell]}.inside();
    int mine = 0;
    for_each_at(
        e, inside, cases, [](int edge) { return edge; }, [&](int, int) { ++mine; });
    int end = mine;
    UNROLL
    for (int step = 1; step < 4; step *= 2) {
        const int other = __shfl_up_sync(lanes, end, unsigned(step), 4);
        end += k >= step ? other : 0;
    }
    int at = end - mine;
    for_each_at(
        e, inside, cases, [&](int edge) { return names.vertex(cell, edge); },
        [&](int next, int last) {
            const std::size_t here = d.at_ring(v, at++);
            d.next[here] = next, d.last[here] = last;
        });
    if (k == 3) d.ring[v] = end;
}

__device__ void draw(const SurfaceView& d, bool some)
{
    for (int c = int(threadIdx.x); c < d.categories; c += march_threads) {
        const unsigned from = unpacked(d.before[c * d.layer_blocks()]).triangles;
        const unsigned to = unpacked(d.before[(c + 1) * d.layer_blocks()]).triangles;
        d.draws[c] = {some ? 3 * (to - from) : 0, 1, some ? 3 * from : 0, 0, 0};
    }
}

// Places the block's vertices, with four threads each.
__device__ void place_all(const SurfaceView& d, const Place& p, const Names& names,
                          const MarchTable& cases, const unsigned char* owners, int count, int to)
{
    const int lane = int(threadIdx.x) % 32;
    for (int t = int(threadIdx.x); t < 4 * count; t += march_threads) {
        const int l = owners[t / 4] / 4, axis = owners[t / 4] % 4;
        const int v = names.first_of(tile_at(l), axis);
        if (t % 4 == 0) place(d, p, v, l, axis, to);
        find_ring(d, names, cases, v, l, axis, t % 4, 15u << lane / 4 * 4);
    }
}

// A cell's triangles, from the first of the block's.
__device__ void connect(const Names& names, const MarchTable& cases, int cell, Int3* triangles)
{
    const Mark mark{names.marks[cell]};
    march(
        mark.inside(), cases,
        [&](int low, int axis) { return names.first_of(cell + tile_step(low), axis); },
        [&](int t, Int3 triangle) { triangles[mark.triangle() + t] = triangle; });
}

__global__ void __launch_bounds__(march_threads)
    march_kernel(const __grid_constant__ SurfaceView d, int to)
{
    __shared__ Names names;
    __shared__ alignas(unsigned) MarchTable cases;
    __shared__ unsigned char owners[3 * block_nodes];  // of the block's vertices: 4 * node + axis
    copy(table, cases);
    wait_upstream_and_trigger();
    if (unchanged(d)) return;
    const int l = int(threadIdx.x), blocks = d.active[1];
    int block = d.skin[blockIdx.x];  // before its validity is known: the loads overlap
    const bool some = vertex_count(d) > 0;
    if (blockIdx.x == 0) draw(d, some);
    if (blockIdx.x == 0 && l == 0) d.active[2] = d.active[0];
    if (!some || int(blockIdx.x) >= blocks) return;
    for (int k = int(blockIdx.x); k < blocks; k += int(gridDim.x)) {
        if (k != int(blockIdx.x)) block = d.skin[k];
        const Amounts here = unpacked(d.counts[block]), before = unpacked(d.before[block]);
        const Place p(d, block);
        name(d, p, names);
        __syncthreads();
        const Mark mark{l < block_nodes ? names.marks[tile_at(l)] : 0};
        UNROLL
        for (int axis = 0; axis < 3; ++axis)
            if (mark.crossed() >> axis & 1)
                owners[mark.vertex() + rank_of(mark.crossed(), axis)] =
                    static_cast<unsigned char>(4 * l + axis);
        __syncthreads();
        if (l < block_nodes) connect(names, cases, tile_at(l), d.triangles + before.triangles);
        place_all(d, p, names, cases, owners, int(here.vertices), to);
        __syncthreads();
    }
}

cudaError_t sum(const SurfaceView& d, void* scratch, std::size_t& bytes, cudaStream_t stream)
{
    return cub::DeviceScan::ExclusiveSum(scratch, bytes, d.counts, d.before, d.blocks + 1, stream);
}

}  // namespace

std::size_t scan_scratch_bytes(int blocks)
{
    std::size_t bytes = 0;
    SurfaceView d{};
    d.blocks = blocks;
    check(sum(d, nullptr, bytes, nullptr), "scan");
    return bytes;
}

void count(const SurfaceView& view, int processors, cudaStream_t stream)
{
    launch_pdl("surface count", count_kernel, min(blocks_for(view.blocks, warps), 16 * processors),
               count_threads, stream, view);
}

void scan(const SurfaceView& view, const ScanSpace& space, cudaStream_t stream)
{
    const ProfilerRange range{"surface scan"};
    std::size_t bytes = space.bytes;
    check(sum(view, space.scratch, bytes, stream), "surface scan");
}

void march(const SurfaceView& view, int to, int processors, cudaStream_t stream)
{
    launch_pdl("surface march", march_kernel, min(view.blocks, 16 * processors), march_threads,
               stream, view, to);
}

}  // namespace knead::gpu
