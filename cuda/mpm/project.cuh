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

// Contact candidates of the particle at x, if its nodes are stored; null: none.
__device__ inline const Mask* near_tools(const NearView& d, const Lattice<float>& lattice,
                                         Vec3<float> x)
{
    const Int3 cell = lattice.cell_of(x);
    const bool in = contains(d.stored, x) && d.passes > 0;
    if (!in) return nullptr;
    const Mask& mask = d.masks[lattice.block_of(cell)];
    return empty(loaded(mask)) ? nullptr : &mask;
}

// Nodes of the velocity field for the particle's label, or its colour, or both, in substep n.
template <bool blades, bool bodies>
__device__ const float4* nodes_for(const G2pView& d, const Particle<float>& q, int n)
{
    const float4* nodes = d.velocities[n & 1];
    if constexpr (blades) nodes += q.label() * unsigned(d.lattice.node_count());
    if constexpr (bodies) nodes += d.materials.colours[q.object] * d.lattice.node_count();
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
                                      const SubstepContext& later, const ProjectionPhase& scratch,
                                      bool check, unsigned& covered)
{
    const Mask* own = check ? near_tools(d.near, d.lattice, q.x) : nullptr;
    bool in = own;
    if (!__any_sync(all_lanes, in)) return 0;
    const float around = per_cell();
    __syncwarp();  // other lanes have ended the gather phase, last read in per_cell()
    scratch.spill_strain(q);
    if constexpr (!blades) scratch.spill_C(q.C);
    const Mask& mask = in ? *own : d.near.masks[0];
    const Colliders<float> colliders = d.contact.colliders(later.n - 1);
    if constexpr (blades) {
        std::uint32_t touched = 0;
        if (in) covered = cut(q, colliders, mask, d.lattice.dx, touched);
        add_touched(later.clock(), touched);
    }
    scratch.spill_x(q.x);
    WarpContact<32, brief> contact(scratch.search(), colliders, d.near.pushout.skin);
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
    const float depth = come_out(q.x, scratch.reloaded_x(), q.x, d.near.pushout.shallow);
    scratch.reload_strain(q);
    if constexpr (!blades) q.C = scratch.reloaded_C();
    return depth;
}

// Projects the lane's particle if `moves`: out of tools, inside the walls, into the stored region.
template <Features f, class PerCell>
__device__ void project(Particle<float>& q, PerCell&& per_cell, const G2pView& d,
                        const SubstepContext& later, const ProjectionPhase& scratch, bool moves,
                        Events& happened)
{
    if constexpr (f.tools)
        happened.depth = project_out_of_tools<f.blades, !f.mixed>(q, per_cell, d, later, scratch,
                                                                  moves, happened.covered);
    happened.projected = happened.depth > 0;
    if (contains(d.free, q.x)) return;
    happened.confined = confine(q, d.walls);
    q.x = nearest(d.near.stored, q.x);
}

}  // namespace knead::gpu
