// Mass and momentum of a thread block's particles to the grid. Lanes of a warp whose particles
// share a cell are put side by side; each writes down what every row of three nodes gets of it;
// then 27 lanes, one a node, walk each cell's particles and add to a tile of nodes of the warp's
// own; and what the tiles of the block's warps hold goes to memory, a vector atomic a node. No sum
// depends on the schedule but those of the atomics, and in fixed point not even these. Cells are
// found from where the particles are now, so drift since the sort costs speed, never correctness.
//
// Shuffling the 108 numbers of a particle together takes 324 shuffles a lane, and adding runs of
// them to memory as they come 5 atomics a particle, which at four cycles each took half of the
// stage: docs/measured.md.
#pragma once
#include <nv/target>

#include "blade.h"
#include "launch.cuh"
#include "p2g.h"
#include "stages.cuh"

namespace knead::gpu {

constexpr unsigned all_lanes = 0xffffffffu;
constexpr int tile_edge = block_edge + 2;  // all that stencils based in one block reach
constexpr int tile_nodes = tile_edge * tile_edge * tile_edge;

template <bool blades>
constexpr int scatter_threads = run_length(blades);
template <bool blades>
constexpr int scatter_warps = scatter_threads<blades> / 32;

// Shared memory of one thread block.
template <bool blades>
struct ScatterSpace {
    static constexpr int warps = scatter_warps<blades>, fields = blades ? 3 : 1;
    float4 rows[warps][32][9];  // by particle: momentum and mass of rows of nodes, (z, y) of them
    float4 slopes[warps][32];   // of a row's momentum per mass along x; the particle's sides
    float4 weights[warps][32];  // along x
    float4 tiles[warps][fields][tile_nodes];
    Int3 corners[warps];  // first node of each tile
};

// Adds n to *to: one vector atomic where the card has it.
__device__ inline void add(float4* to, const float4& n)
{
    NV_IF_ELSE_TARGET(NV_PROVIDES_SM_90, (atomicAdd(to, n);),
                      (atomicAdd(&to->x, n.x); atomicAdd(&to->y, n.y); atomicAdd(&to->z, n.z);
                       atomicAdd(&to->w, n.w);))
}

// Integers add up to the same bits in any order.
__device__ inline void add(long long* to, const float4& n, float momentum_scale, float mass_scale)
{
    const auto one = [](long long* at, float value) {
        atomicAdd(reinterpret_cast<unsigned long long*>(at),
                  static_cast<unsigned long long>(__float2ll_rn(value)));
    };
    one(to + 0, momentum_scale * n.x);
    one(to + 1, momentum_scale * n.y);
    one(to + 2, momentum_scale * n.z);
    one(to + 3, mass_scale * n.w);
}

__device__ inline void add(const GridView& grid, int parity, int node, const float4& n)
{
    if (grid.sums[parity])
        add(grid.sums[parity] + 4 * std::size_t(node), n, grid.momentum_scale, grid.mass_scale);
    else
        add(grid.nodes[parity] + node, n);
}

// Lists a block of nodes, once.
__device__ inline void touch(const GridView& grid, int parity, int* active, int block)
{
    unsigned* mark = grid.touched[parity] + block;
    if (__ldcg(mark) || atomicExch(mark, 1u)) return;
    grid.list[parity][atomicAdd(active, 1)] = block;
}

// Which of the eight blocks from that of `base` on the stencil there lies in: a bit each.
__device__ inline unsigned reached(Int3 base)
{
    unsigned bits = 1;
    if ((base.x & 3) > 1) bits |= bits << 1;
    if ((base.y & 3) > 1) bits |= bits << 2;
    if ((base.z & 3) > 1) bits |= bits << 4;
    return bits;
}
__device__ inline Int3 corner_of(int k) { return {k & 1, k >> 1 & 1, k >> 2}; }

// A lane among those whose particles share its cell.
struct Cell {
    unsigned lanes;  // of the cell
    int slot;        // place of the lane when cells are put side by side
    bool first;      // of its cell
};
__device__ inline Cell cell_of(int node)
{
    const int lane = int(threadIdx.x & 31);
    const unsigned lanes = __match_any_sync(all_lanes, node);
    const int first = __ffs(int(lanes)) - 1, own = lane == first ? __popc(lanes) : 0;
    int until = own;
    UNROLL
    for (int k = 1; k < 32; k *= 2) {
        const int other = __shfl_up_sync(all_lanes, until, unsigned(k));
        if (lane >= k) until += other;
    }
    const int start = __shfl_sync(all_lanes, until - own, first);
    return {lanes, start + __popc(lanes & ((1u << lane) - 1)), lane == first};
}

// The scatter of one warp for substep n, all of whose lanes call it; `valid` ones have a particle.
// Blocks of nodes that get mass are listed in the grid, which is clear before.
template <bool blades>
class WarpScatter {
  public:
    __device__ WarpScatter(const Views& views, ScatterSpace<blades>& space, int n)
        : d(views), s(space), parity(n & 1), active(views.clock->active + n % 3)
    {
    }

    __device__ void operator()(const Particle<float>& q, const Material<float>& m, bool valid,
                               float dt)
    {
        clear();
        const Stencil<float> stencil = knead::stencil(q.x, d.lattice.dx);
        const Int3 base = stencil.base;
        const Cell cell = cell_of(valid ? d.lattice.index(base) : -1);
        write_down(q, m, stencil, cell.slot, dt);
        const Int3 corner = {__shfl_sync(all_lanes, base.x & ~3, 0),
                             __shfl_sync(all_lanes, base.y & ~3, 0),
                             __shfl_sync(all_lanes, base.z & ~3, 0)};
        if (lane == 0) s.corners[warp] = corner;
        const Int3 at = base - corner;
        const bool inside = at.x >= 0 && at.y >= 0 && at.z >= 0 && at.x < block_edge &&
                            at.y < block_edge && at.z < block_edge;
        list_blocks(base, corner, valid && inside, valid && !inside && cell.first);
        const int place = inside ? (at.z * tile_edge + at.y) * tile_edge + at.x : -1;
        __syncwarp();
        for (unsigned left = __ballot_sync(all_lanes, valid && cell.first); left;
             left &= left - 1) {
            const int leader = __ffs(int(left)) - 1;
            const int begin = __shfl_sync(all_lanes, cell.slot, leader);
            const int count = __popc(__shfl_sync(all_lanes, cell.lanes, leader));
            float4 sums[fields] = {};
            walk(begin, begin + count, sums);
            const int to = __shfl_sync(all_lanes, place, leader);
            if (to >= 0)
                add_to_tile(to, sums);
            else
                add_to_grid(
                    {__shfl_sync(all_lanes, base.x, leader), __shfl_sync(all_lanes, base.y, leader),
                     __shfl_sync(all_lanes, base.z, leader)},
                    sums);
        }
    }

  private:
    static constexpr int fields = ScatterSpace<blades>::fields;
    const Views& d;
    ScatterSpace<blades>& s;
    const int parity;
    int* const active;
    const int lane = int(threadIdx.x & 31), warp = int(threadIdx.x >> 5);
    const int node = least(lane, 26);  // the lane's in a stencil
    const Int3 step = {node % 3, node / 3 % 3, node / 9};

    __device__ void clear()
    {
        float4* tile = s.tiles[warp][0];
        for (int t = lane; t < fields * tile_nodes; t += 32) tile[t] = {0, 0, 0, 0};
    }

    __device__ void write_down(const Particle<float>& q, const Material<float>& m,
                               const Stencil<float>& stencil, int slot, float dt)
    {
        const Momentum<float> a = momentum(q, kirchhoff_stress(q, m), m, stencil, d.lattice.dx, dt);
        const Vec3<float> slope = (1 / m.mass) * a.by_step.a;
        UNROLL
        for (int r = 0; r < 9; ++r) {
            const Node<float> n = knead::node(row_of(a, stencil, r % 3, r / 3));
            s.rows[warp][slot][r] = {n.p.x, n.p.y, n.p.z, n.m};
        }
        s.slopes[warp][slot] = {slope.x, slope.y, slope.z, __uint_as_float(q.label())};
        s.weights[warp][slot] = {stencil.w[0].x, stencil.w[1].x, stencil.w[2].x, 0};
    }

    // Adds what the lane's node gets of the particles in slots [begin, end).
    __device__ void walk(int begin, int end, float4 (&sums)[fields]) const
    {
        const float i = float(step.x);
        const float4* row = &s.rows[warp][begin][node / 3];
        const float4* slope = &s.slopes[warp][begin];
        const float* weight = reinterpret_cast<const float*>(&s.weights[warp][begin]) + step.x;
        for (int k = begin; k < end; ++k, row += 9, ++slope, weight += 4) {
            const float4 r = *row, a = *slope;
            const Node<float> n = knead::node(along(four(Vec3<float>{r.x, r.y, r.z}, r.w), i,
                                                    *weight, Vec3<float>{a.x, a.y, a.z}));
            const auto plus = [&n](float4& sum) {
                sum = {sum.x + n.p.x, sum.y + n.p.y, sum.z + n.p.z, sum.w + n.m};
            };
            plus(sums[0]);
            if constexpr (blades) {
                if (__float_as_uint(a.w) != below) plus(sums[above]);
                if (__float_as_uint(a.w) != above) plus(sums[below]);
            }
        }
    }

    // One cell after the other, so that no two lanes ever add to one node at a time.
    __device__ void add_to_tile(int place, const float4 (&sums)[fields])
    {
        place += (step.z * tile_edge + step.y) * tile_edge + step.x;
        if (lane < 27) {
            UNROLL
            for (int f = 0; f < fields; ++f) {
                float4& to = s.tiles[warp][f][place];
                const float4 a = to, b = sums[f];
                to = {a.x + b.x, a.y + b.y, a.z + b.z, a.w + b.w};
            }
        }
        __syncwarp();
    }

    // Of a cell that lies outside of the warp's tile.
    __device__ void add_to_grid(Int3 base, const float4 (&sums)[fields]) const
    {
        if (lane >= 27) return;
        UNROLL
        for (int f = 0; f < fields; ++f)
            if (sums[f].w > 0)
                add(d.grid, parity, f * d.lattice.node_count() + d.lattice.index(base + step),
                    sums[f]);
    }

    __device__ void list_blocks(Int3 base, Int3 corner, bool inside, bool alone) const
    {
        const unsigned bits = __reduce_or_sync(all_lanes, inside ? reached(base) : 0);
        if (lane < 8 && (bits >> lane & 1))
            touch(d.grid, parity, active, d.lattice.block_of(corner + 4 * corner_of(lane)));
        if (!alone) return;
        const unsigned own = reached(base);
        for (int k = 0; k < 8; ++k)
            if (own >> k & 1)
                touch(d.grid, parity, active, d.lattice.block_of(base + 4 * corner_of(k)));
    }
};

// The tiles' sums to memory, by all threads of a block; tiles in one place that follow each other
// are added up first.
template <bool blades>
__device__ void flush(const Views& d, const ScatterSpace<blades>& s, int n)
{
    constexpr int warps = ScatterSpace<blades>::warps, fields = ScatterSpace<blades>::fields;
    for (int t = int(threadIdx.x); t < fields * tile_nodes; t += 32 * warps) {
        const int f = t / tile_nodes, k = t % tile_nodes;
        const Int3 at = {k % tile_edge, k / tile_edge % tile_edge, k / (tile_edge * tile_edge)};
        float4 sum{0, 0, 0, 0};
        UNROLL
        for (int w = 0; w < warps; ++w) {
            const float4 part = s.tiles[w][f][k];
            sum = {sum.x + part.x, sum.y + part.y, sum.z + part.z, sum.w + part.w};
            const Int3 a = s.corners[w], b = s.corners[w + 1 < warps ? w + 1 : w];
            if (w + 1 < warps && a.x == b.x && a.y == b.y && a.z == b.z) continue;
            if (sum.w > 0)
                add(d.grid, n & 1, f * d.lattice.node_count() + d.lattice.index(a + at), sum);
            sum = {0, 0, 0, 0};
        }
    }
}

// Calls visit(run) for the run of particles that is the thread block's, or where clay may be still
// for as many of the listed ones as fall to it. The launch's first `others` blocks do other things.
template <bool rests, class Visit>
__device__ void for_each_run(const Views& d, int others, Visit&& visit)
{
    const int first = int(blockIdx.x) - others;
    if constexpr (rests) {
        const int stride = int(gridDim.x) - others, count = d.clock->listed;
        for (int at = first; at < count; at += stride) {
            visit(d.rest.list[at]);
            __syncthreads();  // shared memory is used anew
        }
    } else {
        visit(first);
    }
}

// Thread blocks for all runs. Where few of many may be listed, no more than keep the device busy:
// starting one for nothing takes time, too.
inline int blocks_for_runs(const Views& views, const Needs& needs, int multiprocessors)
{
    const int runs = blocks_for(views.particles[0].count, run_length(needs));
    return needs.rests ? least(runs, 24 * multiprocessors) : runs;
}

}  // namespace knead::gpu
