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

// What the sums for substep n add to the own pressure of a particle [Pa]; nothing to one that has
// slept meanwhile, in a cell of such.
__device__ inline float pressure_beyond(const PressureView& d, const Lattice<float>& lattice,
                                        const Particle<float>& q, const Material<float>& m, int n)
{
    if (!shares_pressure(m)) return 0;
    const CellPressure& of = cell_of(d, lattice, q, n);
    if (of.volume == 0) return 0;
    const PressureSum<float> sum{float(of.pressure) / d.pressure_scale,
                                 float(of.volume) / d.volume_scale};
    return sum.beyond(own_pressure(q, m));
}

}  // namespace knead::gpu
