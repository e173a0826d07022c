// Pressure that a cell's particles share, where clay hardly changes its volume.  (7a)
#include "cuda/mpm/stencil.h"
#include "host/solver/cpu/solver.h"

namespace knead {

// What the mean pressure of its cell adds to each of a block's particles: as the substep before
// found it, or in a frame's first as it is. Particles of a cell are of one block.  (7a)
template <class R>
void CpuSolver<R>::share_pressure(int slot)
{
    PressureSum<R> cells[block_nodes];
    const auto shared = [&](auto&& use) {
        for (int i : bins.members(slot)) {
            const Particle<R>& p = q[std::size_t(i)];
            const Material<R>& m = materials[std::size_t(p.object)];
            if (!shares_pressure(m)) continue;
            const int cell = lattice.index(base_node(p.x, lattice.dx)) % block_nodes;
            use(i, own_pressure(p, m), m.volume, cells[cell]);
        }
    };
    shared([](int, R own, R volume, PressureSum<R>& sum) { sum.add(own, volume); });
    shared([&](int i, R own, R, PressureSum<R>& sum) {
        const R now = sum.beyond(own);
        beyond[std::size_t(i)] = pressed ? coming[std::size_t(i)] : now;
        coming[std::size_t(i)] = now;
    });
}

template void CpuSolver<float>::share_pressure(int);

}  // namespace knead
