// Gather of grid velocities to a thread's particle: the loads of g2p.h, in the order that needs
// fewest registers.
#pragma once
#include <vector_types.h>

#include "cuda/mpm/g2p.h"

namespace knead::gpu {

// Indices of the first nodes of a stencil's columns along z, by axis: an index is the sum of the
// three.
struct Offsets {
    int x[3], y[3], z;
    HD int column(Int3 step) const { return x[step.x] + y[step.y] + z; }
};
HD Offsets offsets(const Lattice<float>& lattice, Int3 base)
{
    Offsets o{{}, {}, lattice.index({0, 0, base.z})};
    UNROLL
    for (int k = 0; k < 3; ++k) {
        o.x[k] = lattice.along_x(base.x + k);
        o.y[k] = lattice.along_y(base.y + k);
    }
    return o;
}

// Gathers from `nodes`, the nodes of one field. Passes the mass of the node nearest to the particle
// to `nearest` and, if `weighed`, each plane's contribution to the mass per cell [kg] to `weigh`.
// Their sum is mass_around(); gather() on Fours would compute it, too, but hold it in a register
// throughout. at_last() is called before the loads of the last plane, to issue further loads.
template <bool weighed, class Nearest, class Weigh, class AtLast>
__device__ void gather_from(const float4* nodes, const Lattice<float>& lattice,
                            const Stencil<float>& s, Particle<float>& q, Nearest&& nearest,
                            Weigh&& weigh, AtLast&& at_last)
{
    const Offsets o = offsets(lattice, s.base);
    [[maybe_unused]] float column, in_plane;
    gather(q, s, lattice.spacing, [&](Int3 step) {
        // Loads of one plane at a time: the results of all would not fit in registers.
        if (step.y == 0 && step.z == 0) __syncwarp();
        if (step == Int3{2, 0, 0}) at_last();
        const float4 v = (nodes + o.column(step))[step.z * Lattice<float>::along_z];
        if (step == nearest_node) nearest(v.w);
        if constexpr (weighed) {
            column = step.z == 0 ? s.w[0].z * v.w : column + s.w[step.z].z * v.w;
            if (step.z == 2)
                in_plane = step.y == 0 ? s.w[0].y * column : in_plane + s.w[step.y].y * column;
            if (step.z == 2 && step.y == 2) weigh(step.x, s.w[step.x].x * in_plane);
        }
        return Vec3<float>{v.x, v.y, v.z};
    });
}

}  // namespace knead::gpu
