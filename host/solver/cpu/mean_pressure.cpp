// Mean pressure per cell, for nearly incompressible clay.  (7a)
#include "cuda/mpm/mean_pressure.h"

#include "cuda/mpm/stencil.h"
#include "host/solver/cpu/solver.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

// Sums the pressure of all of the block's particles per cell and applies the mean to `members`.
template <class R>
void CpuSolver<R>::share_pressure(int slot, Bins::Members members)
{
    PressureSum<R> cells[block_nodes];
    const auto shared = [&](Bins::Members of, auto&& use) {
        for (int i : of) {
            Particle<R>& p = q[std::size_t(i)];
            const Material<R>& m = materials[std::size_t(p.object)];
            if (!shares_pressure(m)) continue;
            use(p, m, cells[lattice.index(base_node(p.x, lattice.dx)) % block_nodes]);
        }
    };
    shared(bins.members(slot), [](Particle<R>& p, const Material<R>& m, PressureSum<R>& sum) {
        sum.add(own_pressure(p, m), m.volume);
    });
    shared(members, [](Particle<R>& p, const Material<R>& m, const PressureSum<R>& sum) {
        apply_mean_pressure(p, m, sum.mean());
    });
}

template void CpuSolver<float>::share_pressure(int, Bins::Members);

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
