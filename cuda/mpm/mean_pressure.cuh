// Cell-averaged pressure on the device: fixed-point sums, bitwise independent of the order.
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

// Relaxes the particle's pressure towards its cell's mean, by the sums for substep n. Skipped in a
// cell whose particles were all still in the previous substep: it has no sums.
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
