// Shared memory of a warp in p2g and g2p. The same memory serves three phases in turn:
//
//   gather       values that the loads of velocities would crowd out of registers. Each lane reads
//                only what it wrote itself.
//   projection   of particles near tools: the contact search, and particle state that the search
//                does not use. Begins with a barrier of the warp: it overwrites slots that other
//                lanes have used in the gather.
//   scatter      the particles' contributions to nodes. Begins with a barrier of the warp; lanes
//                read what all others have written.
//
// The scatter's arrays are the memory; structures of the other phases lie over a warp's part of one
// of them. The arrays are one after the other, each for all warps of the thread block: whole warps
// one after the other, or unions, were tried and made some kernels of g2p spill or grow. Rows of 32
// values, one per lane, and vectors of 16 bytes have no bank conflicts.
#pragma once
#include <vector_types.h>

#include <cstddef>

#include "cuda/contact/contact.cuh"
#include "cuda/mpm/features.h"
#include "cuda/mpm/particle.h"

namespace knead::gpu {

template <bool blades>
constexpr int scatter_threads = run_length({.blades = blades});
template <bool blades>
constexpr int scatter_warps = scatter_threads<blades> / 32;

// Over `slopes`.
struct GatherPhase {
    float k[32];             // Particle::k
    float nearest_mass[32];  // of the node nearest to the particle [kg]
    float x_z[32];           // Particle::x.z [m]
    float unused[32];
    float plane_mass[3][32];  // contribution of each plane of nodes to the mass per cell [kg]
};

// The projection, over `columns`, `slopes` and `cells`.
struct SearchPart {
    ContactSpace<32> search;
    float C[7][32];  // Particle::C [1/s], row by row, its first elements
};
struct SpillPart {
    float4 strain[2][32];  // Particle::e, k, object
    float C[2][32];        // the last elements of Particle::C [1/s]
    float x_xy[2][32];     // Particle::x before the projection [m], without z
};
struct HeightPart {
    int x_z[32];  // bits of the z that SpillPart::x_xy lacks
};

// Rows of a phase begin at multiples of 128 bytes, as the warps' parts do, and lanes then use the
// same banks in all of them.
static_assert(sizeof(GatherPhase) == 7 * 128 && offsetof(GatherPhase, plane_mass) == 4 * 128);
static_assert(sizeof(ContactSpace<32>) % 128 == 0 && offsetof(SearchPart, C) % 128 == 0);
static_assert(offsetof(SpillPart, C) == 8 * 128 && offsetof(SpillPart, x_xy) == 10 * 128);

// A phase's structure in the memory of another phase.
template <class Phase, class Memory>
__device__ Phase& overlaid(Memory& memory)
{
    static_assert(sizeof(Phase) <= sizeof(Memory) && alignof(Phase) <= alignof(Memory));
    return reinterpret_cast<Phase&>(memory);
}

// The projection of a warp's particles.
struct ProjectionPhase {
    SearchPart& first;
    SpillPart& second;
    HeightPart& third;
    const unsigned lane = threadIdx.x & 31;

    __device__ ContactSpace<32>& search() const { return first.search; }
    __device__ float& C(int k) const { return k < 7 ? first.C[k][lane] : second.C[k - 7][lane]; }

    __device__ void spill_strain(const Particle<float>& q) const
    {
        second.strain[0][lane] = {q.e.xx, q.e.yy, q.e.zz, q.e.xy};
        second.strain[1][lane] = {q.e.xz, q.e.yz, q.k, __int_as_float(q.object)};
    }
    __device__ void reload_strain(Particle<float>& q) const
    {
        asm volatile("" ::: "memory");
        const float4 a = second.strain[0][lane], b = second.strain[1][lane];
        q.e = {a.x, a.y, a.z, a.w, b.x, b.y};
        q.k = b.z, q.object = __float_as_int(b.w);
    }
    __device__ void spill_C(const Mat3<float>& of) const
    {
        const float all[9] = {of.a.x, of.a.y, of.a.z, of.b.x, of.b.y,
                              of.b.z, of.c.x, of.c.y, of.c.z};
        UNROLL
        for (int k = 0; k < 9; ++k) C(k) = all[k];
    }
    __device__ Mat3<float> reloaded_C() const
    {
        asm volatile("" ::: "memory");
        return {{C(0), C(1), C(2)}, {C(3), C(4), C(5)}, {C(6), C(7), C(8)}};
    }
    __device__ void spill_x(Vec3<float> x) const
    {
        second.x_xy[0][lane] = x.x, second.x_xy[1][lane] = x.y,
        third.x_z[lane] = __float_as_int(x.z);
    }
    __device__ Vec3<float> reloaded_x() const
    {
        asm volatile("" ::: "memory");
        return {second.x_xy[0][lane], second.x_xy[1][lane], __int_as_float(third.x_z[lane])};
    }
};

// The scratch of all warps of a thread block.
template <bool blades>
struct WarpScratch {
    static constexpr int warps = scatter_warps<blades>;
    // The scatter: particles by slot, see WarpScatter.
    float4 columns[warps][32][9];  // momentum and mass of columns of nodes
    float4 slopes[warps][32][3];   // velocity increment at each step along z, and the weight there
    int cells[warps][32];          // index of the stencil's base
    unsigned sides[blades ? warps : 0][32];  // Particle::label()

    // The calling warp's other phases.
    __device__ GatherPhase& gather() { return overlaid<GatherPhase>(slopes[threadIdx.x >> 5]); }
    __device__ ProjectionPhase projection()
    {
        const unsigned warp = threadIdx.x >> 5;
        return {overlaid<SearchPart>(columns[warp]), overlaid<SpillPart>(slopes[warp]),
                overlaid<HeightPart>(cells[warp])};
    }
};

// Their sizes limit how many thread blocks fit a multiprocessor.
static_assert(sizeof(WarpScratch<false>) == 4 * (36 + 12 + 1) * 128);
static_assert(sizeof(WarpScratch<true>) == 2 * (36 + 12 + 1 + 1) * 128);
static_assert(alignof(WarpScratch<false>) == 16 && alignof(WarpScratch<true>) == 16);

}  // namespace knead::gpu
