// Scatter of a warp's particles. Lanes whose particles share a cell are placed side by side; each
// writes its contribution to every column of three nodes to shared memory. Then the warp loops over
// all particles, one lane per node of the stencil, and at the end of each cell adds the sums to
// global memory, one vector atomic per node. Only the order of the atomics depends on the schedule;
// in fixed point the result does not. Cells are computed from current positions, so drift since the
// sort costs speed, never correctness.
//
// Reducing the 108 numbers of a particle by shuffles takes 324 shuffles per lane; summing the cells
// of four warps in tiles of shared memory first saves four atomics of five, and costs more than
// these: docs/engineering/kernels.md.
#pragma once
#include <nv/target>

#include "cuda/contact/cut.h"
#include "cuda/math/node4.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/p2g.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/substep.cuh"
#include "cuda/mpm/views.cuh"
#include "cuda/mpm/warp_scratch.cuh"

namespace knead::gpu {

// From the stencil's base to its columns, of nodes along z, in the order of `columns`.
HD constexpr Int3 column_step(int c) { return {c % 3, c / 3, 0}; }

// The field to which a particle scatters, with bodies: that of its colour and label.
template <Features f>
__device__ int field_of(const Materials& materials, const Particle<float>& q)
{
    if constexpr (!f.bodies) return 0;
    return materials.colours[q.object] + (f.blades ? int(q.label()) : 0);
}

// Adds n to *to: one vector atomic where the GPU supports it.
__device__ inline void add(float4* to, const float4& n)
{
    NV_IF_ELSE_TARGET(NV_PROVIDES_SM_90, (atomicAdd(to, n);),
                      (atomicAdd(&to->x, n.x); atomicAdd(&to->y, n.y); atomicAdd(&to->z, n.z);
                       atomicAdd(&to->w, n.w);))
}

// Integer sums do not depend on the order.
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

// The lane's slot when those whose particles share a cell are placed side by side.
__device__ inline int slot_of(int node)
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
    return start + __popc(lanes & ((1u << lane) - 1));
}

// Rematerialised: a register from run to run would cost more.
__device__ inline int lane_now()
{
    int lane;
    asm volatile("mov.u32 %0, %%laneid;" : "=r"(lane));
    return lane;
}

// Lanes by the nodes of a stencil: the first nodes of eight columns, their second, their third,
// then the ninth column's nodes, each on two lanes: a vector load takes half the time if adjacent
// lanes share the address.
struct Lane {
    int column, k;  // k: step along z
    bool holds;     // false: a duplicate
};
__device__ inline Lane lane_of(int lane)
{
    const bool ninth = lane >= 24;
    return {ninth ? 8 : lane & 7, ninth ? min(lane >> 1 & 3, 2) : lane >> 3,
            !ninth || (lane < 30 && !(lane & 1))};
}

// Scatter of one warp for substep n. Warp-collective; lanes with `valid` have a particle. Lists the
// blocks of nodes that receive mass. Precondition: the grid is clear. `begins`: first scatter of a
// frame; `relisted`: its list is empty at first. `bodies`: particles have a velocity field by their
// colour.
template <bool blades, bool begins = false, bool bodies = false>
class WarpScatter {
  public:
    __device__ WarpScatter(const ScatterView& view, WarpScratch<blades>& scratch, int n,
                           bool relisted = false)
        : d(view),
          s(scratch),
          n(n),
          relisted(relisted),
          sums_of_nodes(view.sums[0] ? static_cast<void*>(view.sums[n & 1]) : view.nodes[n & 1])
    {
    }

    // per_mass: 1 over the mass of the material [1/kg]. `field`: with bodies, the velocity field.
    __device__ void operator()(const Particle<float>& q, const Material<float>& m, float per_mass,
                               bool valid, float dt, int field = 0)
    {
        const Stencil<float> stencil = knead::stencil(q.x, d.lattice.spacing);
        // Nodes of all fields are numbered in one row. Equal cells of different fields differ.
        const int first = bodies ? field * d.lattice.node_count() : 0;
        const int node = valid ? first + d.lattice.index(stencil.base) : nowhere,
                  slot = slot_of(node);
        __syncwarp();  // other lanes have ended the phases before
        write_down(q, m, per_mass, stencil, slot, dt);
        s.cells[warp][slot] = node;
        __syncwarp();
        walk();
        list_last();
    }

  private:
    static constexpr int fields = blades ? 3 : 1, nowhere = 0x7fffffff;
    const ScatterView& d;
    WarpScratch<blades>& s;
    const int n;
    const bool relisted;
    int last = -1, mark = 0;    // the last block of nodes added to; its mark
    void* const sums_of_nodes;  // float4, or in fixed point four long long
    const int lane = lane_now(), warp = int(threadIdx.x >> 5);
    const Lane own = lane_of(lane);
    const Int3 step = column_step(own.column) + Int3{0, 0, own.k};

    __device__ void write_down(const Particle<float>& q, const Material<float>& m, float per_mass,
                               const Stencil<float>& stencil, int slot, float dt)
    {
        const Momentum<float> a =
            momentum(q, kirchhoff_stress(q, m), m, per_mass, stencil, d.lattice.spacing, dt);
        UNROLL
        for (int c = 0; c < 9; ++c) {
            const Int3 to = column_step(c);
            const Node<float> n = knead::node(column_of(a, stencil, to.x, to.y));
            s.columns[warp][slot][c] = {n.p.x, n.p.y, n.p.z, n.m};
        }
        UNROLL
        for (int k = 0; k < 3; ++k) {
            const Vec3<float> slope = float(k) * a.along_z;
            s.slopes[warp][slot][k] = {slope.x, slope.y, slope.z, stencil.w[k].z};
        }
        if constexpr (blades) s.sides[warp][slot] = q.label();
    }

    // Sums the contributions to the lane's node, slot by slot.
    __device__ void walk()
    {
        constexpr int together = 4, turn = 2 * together;
        const float4 *column = &s.columns[warp][0][own.column], *slope = &s.slopes[warp][0][own.k];
        const int* cell = s.cells[warp];
        // One bit per slot: the last of its cell.
        unsigned ends = __ballot_sync(all_lanes, lane == 31 || cell[lane] != cell[lane + 1]);
        float4 sums[fields] = {};
        for (int first = 0; first < 32; first += turn) {
            UNROLL
            for (int half = 0; half < turn; half += together) {
                float4 r[together], a[together];
                UNROLL
                for (int k = 0; k < together; ++k)
                    r[k] = column[9 * (half + k)], a[k] = slope[3 * (half + k)];
                UNROLL
                for (int k = 0; k < together; ++k) {
                    add_up(r[k], a[k], first + half + k, sums);
                    if (!(ends >> (half + k) & 1)) continue;
                    add_to_grid(cell[half + k], sums);
                    UNROLL
                    for (float4& sum : sums) sum = {0, 0, 0, 0};
                }
            }
            column += 9 * turn, slope += 3 * turn, cell += turn;
            ends >>= turn;
        }
    }
    // Contribution of one particle to the lane's node.
    __device__ void add_up(const float4& column, const float4& slope, int slot,
                           float4 (&sums)[fields]) const
    {
        const Node<float> n =
            knead::node(along(four(Vec3<float>{column.x, column.y, column.z}, column.w), slope.w,
                              Vec3<float>{slope.x, slope.y, slope.z}));
        const auto plus = [&n](float4& sum) {
            sum = {sum.x + n.p.x, sum.y + n.p.y, sum.z + n.p.z, sum.w + n.m};
        };
        plus(sums[0]);
        if constexpr (blades) {
            const unsigned sides = s.sides[warp][slot];
            if (sides != below) plus(sums[above]);
            if (sides != above) plus(sums[below]);
        }
    }
    // Adds the lane's node's sums of the cell at node `base` to the grid.
    __device__ void add_to_grid(int base, float4 (&sums)[fields])
    {
        // Copied here, where cells end, rather than with every particle.
        UNROLL
        for (float4& a : sums) asm volatile("" : "+f"(a.x), "+f"(a.y), "+f"(a.z), "+f"(a.w));
        if (base == nowhere || !own.holds) return;
        const unsigned node = unsigned(d.lattice.stepped(base, step));
        UNROLL
        for (int f = 0; f < fields; ++f)
            if (f == 0 || sums[f].w > 0)
                add_to_node(unsigned(f * d.lattice.node_count()) + node, sums[f]);
        list_last();
        unsigned at = node;
        if constexpr (bodies)
            while (at >= unsigned(d.lattice.node_count())) at -= unsigned(d.lattice.node_count());
        last = int(at / block_nodes), mark = d.marks[last];
    }
    // Lists the block that the lane added to last, once. Its mark was loaded then and is used now,
    // which hides the latency. It may be a stale value from L1; that costs one exchange.
    __device__ void list_last() const
    {
        const int own = listed_for(n, begins && relisted);
        if (last < 0 || mark == own || atomicExch(d.marks + last, own) == own) return;
        d.list[n % 3][atomicAdd(&d.clock->active[n % 3], 1)] = last;
        if (begins && d.rim[last]) d.clock->crowded[(n + 1) & 1] = true;
    }
    __device__ void add_to_node(unsigned node, const float4& sum) const
    {
        if (d.sums[0])
            add(static_cast<long long*>(sums_of_nodes) + 4 * std::size_t(node), sum,
                d.momentum_scale, d.mass_scale);
        else
            add(static_cast<float4*>(sums_of_nodes) + node, sum);
    }
};

}  // namespace knead::gpu
