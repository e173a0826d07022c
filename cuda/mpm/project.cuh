// Projection on the device, warp-collective.
#pragma once
#include "cuda/contact/contact.cuh"
#include "cuda/contact/cut.h"
#include "cuda/mpm/events.cuh"
#include "cuda/mpm/g2p.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/project.h"
#include "cuda/mpm/scatter.cuh"
#include "cuda/mpm/substep.cuh"

namespace knead::gpu {

// Spill and reload particle state that the contact search does not use: in registers it would crowd
// out the loop over primitives. `at`: two slots, 32 apart.
__device__ inline void spill(const Particle<float>& q, float4* at)
{
    at[0] = {q.e.xx, q.e.yy, q.e.zz, q.e.xy};
    at[32] = {q.e.xz, q.e.yz, q.k, __int_as_float(q.object)};
}
__device__ inline void reload(Particle<float>& q, const float4* at)
{
    asm volatile("" ::: "memory");
    const float4 a = at[0], b = at[32];
    q.e = {a.x, a.y, a.z, a.w, b.x, b.y};
    q.k = b.z, q.object = __float_as_int(b.w);
}

// Scratch of a warp's contact search within the scatter's shared memory, which is unused until
// then: the search's own space, and slots for spilled state.
template <bool blades>
struct ContactScratch {
    ScatterSpace<blades>& space;
    const unsigned warp = threadIdx.x >> 5, lane = threadIdx.x & 31;
    static constexpr int kept = 7;  // floats per lane behind the search's space
    static_assert(sizeof(ContactSpace<32>) + kept * 32 * sizeof(float) <= sizeof space.columns[0]);
    __device__ ContactSpace<32>& contact() const
    {
        return reinterpret_cast<ContactSpace<32>&>(space.columns[warp]);
    }
    __device__ float4* strain() const { return &space.slopes[warp][0][0] + lane; }
    __device__ float& rate(int k) const
    {
        float* last = k < kept ? reinterpret_cast<float*>(&contact() + 1) + 32 * k
                               : reinterpret_cast<float*>(strain() - lane + 64) + 32 * (k - kept);
        return last[lane];
    }
    __device__ void spill(const Mat3<float>& C) const
    {
        const float all[9] = {C.a.x, C.a.y, C.a.z, C.b.x, C.b.y, C.b.z, C.c.x, C.c.y, C.c.z};
        UNROLL
        for (int k = 0; k < 9; ++k) rate(k) = all[k];
    }
    __device__ void spill(Vec3<float> x) const
    {
        rate(9) = x.x, rate(10) = x.y, space.cells[warp][lane] = __float_as_int(x.z);
    }
    __device__ Vec3<float> place() const
    {
        asm volatile("" ::: "memory");
        return {rate(9), rate(10), __int_as_float(space.cells[warp][lane])};
    }
    __device__ Mat3<float> rates() const
    {
        asm volatile("" ::: "memory");
        return {
            {rate(0), rate(1), rate(2)}, {rate(3), rate(4), rate(5)}, {rate(6), rate(7), rate(8)}};
    }
};

// Contact candidates of the particle at x, if its nodes are stored; null: none.
__device__ inline const Mask* near_tools(const NearView& d, const Lattice<float>& lattice,
                                         Vec3<float> x)
{
    const Int3 cell = lattice.cell_of(x);
    const bool in = d.stored.holds(x) && d.passes > 0;
    if (!in) return nullptr;
    const Mask& mask = d.masks[lattice.block_of(cell)];
    return empty(loaded(mask)) ? nullptr : &mask;
}

// Nodes of the velocity field for the particle's label in substep n.
template <bool blades>
__device__ const float4* nodes_for(const G2pView& d, const Particle<float>& q, int n)
{
    const float4* nodes = d.velocities[n & 1];
    if constexpr (blades) nodes += q.label() * unsigned(d.lattice.node_count());
    return nodes;
}

// Adds the tools touched by a warp's particles to the frame's counters.
__device__ inline void add_touched(Clock& clock, std::uint32_t tools)
{
    const unsigned all = __reduce_or_sync(all_lanes, tools);
    if (all && (threadIdx.x & 31) == 0) atomicOr(&clock.counters.touched, all);
}

// Projects a warp's particles, for lanes with `check`. Warp-collective. Returns the penetration
// depth of the lane's particle [m].
template <bool blades, bool brief, class PerCell>
__device__ float project_out_of_tools(Particle<float>& q, PerCell&& per_cell, const G2pView& d,
                                      const SubstepContext& later,
                                      const ContactScratch<blades>& borrowed, bool check,
                                      unsigned& covered)
{
    const Mask* own = check ? near_tools(d.near, d.lattice, q.x) : nullptr;
    bool in = own;
    if (!__any_sync(all_lanes, in)) return 0;
    const float around = per_cell();
    __syncwarp();  // spill() overwrites what other lanes read in per_cell()
    spill(q, borrowed.strain());
    if constexpr (!blades) borrowed.spill(q.C);
    const Mask& mask = in ? *own : d.near.masks[0];
    const Colliders<float> colliders = d.contact.colliders(later.n - 1);
    if constexpr (blades) {
        std::uint32_t touched = 0;
        if (in) covered = cut(q, colliders, mask, d.lattice.dx, touched);
        add_touched(later.clock(), touched);
    }
    borrowed.spill(q.x);
    WarpContact<32, brief> contact(borrowed.contact(), colliders, d.near.pushout.skin);
    for (int k = 0; k < d.near.passes && __any_sync(all_lanes, in); ++k) {
        const int near = contact.find_near(
            mask, in, q.x, [&](int i) { return blades && two_sided(colliders, i) ? -1 : 0; });
        if (near == 0) break;
        const Contact<float> hit = contact.deepest(0, near, in, q.x);
        in = hit.phi < 0;
        add_touched(later.clock(), in ? tool_bit(hit.tool) : 0);
        if (in)
            put_out(q.x, q.v, hit, colliders.tools[hit.tool],
                    speed_out(d.near.pushout, -hit.phi, around, later.now));
    }
    const float depth = come_out(q.x, borrowed.place(), q.x, d.near.pushout.shallow);
    reload(q, borrowed.strain());
    if constexpr (!blades) q.C = borrowed.rates();
    return depth;
}

// Projects the lane's particle if `moves`: out of tools, inside the walls, into the stored region.
template <Features f, class PerCell>
__device__ void project(Particle<float>& q, PerCell&& per_cell, const G2pView& d,
                        const SubstepContext& later, ScatterSpace<f.blades>& space, bool moves,
                        Events& happened)
{
    if constexpr (f.tools)
        happened.depth = project_out_of_tools<f.blades, !f.mixed>(
            q, per_cell, d, later, ContactScratch<f.blades>{space}, moves, happened.covered);
    happened.projected = happened.depth > 0;
    if (d.free.holds(q.x)) return;
    happened.confined = confine(q, d.walls);
    q.x = d.near.stored.nearest(q.x);
}

}  // namespace knead::gpu
