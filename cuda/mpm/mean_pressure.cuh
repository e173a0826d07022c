// Pressure that a cell's particles share, on the device: sums in fixed point, the same bits in any
// order.
#pragma once
#include "cuda/mpm/mean_pressure.h"
#include "cuda/mpm/stencil.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

__device__ inline CellPressure& cell_of(const PressureView& d, const Lattice<float>& lattice,
                                        const Particle<float>& q, int n)
{
    return d.cells[n & 1][lattice.index(base_node(q.x, lattice.spacing))];
}

// Adds a particle to its cell's sums for substep n.
__device__ inline void add_pressure(const PressureView& d, const Lattice<float>& lattice,
                                    const Particle<float>& q, const Material<float>& m, int n)
{
    if (!shares_pressure(m)) return;
    const auto add = [](long long& to, float units) {
        atomicAdd(reinterpret_cast<unsigned long long*>(&to),
                  static_cast<unsigned long long>(__float2ll_rn(units)));
    };
    CellPressure& to = cell_of(d, lattice, q, n);
    add(to.pressure, d.pressure_scale * (m.volume * own_pressure(q, m)));
    add(to.volume, d.volume_scale * m.volume);
}

// The particle bears its cell's pressure, by the sums for substep n; not one that has slept
// meanwhile, in a cell of such.
__device__ inline void share_pressure(const PressureView& d, const Lattice<float>& lattice,
                                      Particle<float>& q, const Material<float>& m, int n)
{
    if (!shares_pressure(m)) return;
    const CellPressure& of = cell_of(d, lattice, q, n);
    if (of.volume == 0) return;
    const PressureSum<float> sum{float(of.pressure) / d.pressure_scale,
                                 float(of.volume) / d.volume_scale};
    apply_mean_pressure(q, m, sum.mean());
}

}  // namespace knead::gpu
