// Stages that only scenes with sleeping need.  (29), (30)
#include "host/base/machine.h"
#include "host/base/parallel.h"
#include "host/solver/cpu/solver.h"
#include "host/solver/cpu/transfer.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

// Before the first substep of a frame: determines the activity of blocks and stops sleeping
// particles.
template <class R>
void CpuSolver<R>::update_activity(const Motion& motion)
{
    const double start = wall_seconds();
    const int blocks = lattice.block_count();
    const auto for_each_of = [&](int b, auto&& visit) {
        const auto from = std::size_t(bins.home[std::size_t(b)]);
        const auto to = std::size_t(bins.home[std::size_t(b) + 1]);
        for (std::size_t i = from; i < to; ++i) visit(q[i]);
    };
    std::vector<R> fastest(std::size_t(blocks), 0);
    parallel_for(blocks, LoopOptions{.threads = threads, .chunk = 16}, [&](int b) {
        for_each_of(b, [&](const Particle<R>& p) {
            fastest[std::size_t(b)] = knead::max(fastest[std::size_t(b)], dot(p.v, p.v));
        });
    });
    stillness.begin(fastest, boxes_around(posed, motion, stillness.options.reach));
    parallel_for(blocks, LoopOptions{.threads = threads, .chunk = 16}, [&](int b) {
        const bool still = stillness.holds(b);
        for_each_of(b, [&](Particle<R>& p) {
            if (p.still() == still) return;
            p.hold(still);
            if (still) p.v = {}, p.C = {};
        });
        for_each_splat(b, [&](Gaussian<R>& g) { g.hold(still); });
    });
    bins.bin_only(stillness.listed);
    stage_times[stage_bin].seconds += wall_seconds() - start;
}

// Particles that have moved into a block whose clay is still.
template <class R>
Bins::Members CpuSolver<R>::movers_among(Bins::Members members, std::vector<int>& movers) const
{
    for (int i : members)
        if (!q[std::size_t(i)].still()) movers.push_back(i);
    return {movers.data(), movers.data() + movers.size()};
}

// True if still clay of the block must move: gathers the grid velocity without applying it, and
// tests it (30).
template <class R>
bool CpuSolver<R>::pushes(int slot, R dt, const Tile<R>* tiles) const
{
    const int block = bins.occupied[std::size_t(slot)];
    const bool cut_here = !split.empty() && split[std::size_t(block)];
    const Int3 corner = 4 * lattice.block_at(block);
    for (int i : bins.members(slot)) {
        const Particle<R>& p = q[std::size_t(i)];
        const Stencil<R> s = stencil(p.x, lattice.dx);
        const Node<R>* base =
            tiles[cut_here ? field_of(p.object, p.label()) : 0].node + tile_index(s.base - corner);
        const Gathered<R> sum = gather_rows(s, [&](int j, int k) {
            return row_at(base + tile_index({0, j, k}));
        });
        if (pushed(stillness.options, first_three(sum.v), dt)) return true;
    }
    return false;
}

// After a substep: wakes pushed blocks.
template <class R>
void CpuSolver<R>::wake_roused(FrameStats& stats)
{
    bool any = false;
    stillness.end([&](int b) {
        const int from = bins.home[std::size_t(b)], to = bins.home[std::size_t(b) + 1];
        for (int i = from; i < to; ++i) q[std::size_t(i)].hold(false);
        for_each_splat(b, [&](Gaussian<R>& g) { g.hold(false); });
        stats[Count::woken] += from < to, any = true;
    });
    if (any) bins.bin_only(stillness.listed);
}

template void CpuSolver<float>::update_activity(const Motion&);
template Bins::Members CpuSolver<float>::movers_among(Bins::Members, std::vector<int>&) const;
template bool CpuSolver<float>::pushes(int, float, const Tile<float>*) const;
template void CpuSolver<float>::wake_roused(FrameStats&);

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
