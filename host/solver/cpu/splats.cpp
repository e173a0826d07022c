// Gaussians that follow the clay.  (31)-(34). They are independent: the result does not depend on
// their order.
#include "cuda/mpm/stencil.h"
#include "host/solver/cpu/solver.h"
#include "host/solver/pieces.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

// Sorts the Gaussians by block at the beginning of a frame.
template <class R>
void CpuSolver<R>::arrange_splats()
{
    if (splats.empty() || splats_arranged) return;
    const auto blocks = std::size_t(lattice.block_count());
    std::vector<int> block(splats.size());
    splats_before.assign(blocks + 1, 0), splat_blocks.clear(), splat_order.resize(splats.size());
    for (std::size_t i = 0; i < splats.size(); ++i) {
        block[i] = lattice.block_of(base_node(splats[i].x, lattice.dx));
        ++splats_before[std::size_t(block[i]) + 1];
    }
    for (std::size_t b = 0; b < blocks; ++b) {
        if (splats_before[b + 1] > 0) splat_blocks.push_back(int(b));
        splats_before[b + 1] += splats_before[b];
    }
    std::vector<int> next = splats_before;
    for (std::size_t i = 0; i < splats.size(); ++i)
        splat_order[std::size_t(next[std::size_t(block[i])]++)] = int(i);
    splats_arranged = true;
}

// Processes Gaussians block by block, so that they share a tile of nodes. Gaussians that have left
// the block since the sort load their own nodes.
template <class R>
void CpuSolver<R>::deform(const Lag& lag, bool clear)
{
    if (splats.empty()) return;
    const Colliders<R> colliders = posed.colliders();
    const R per_mass = R(1 / lightest_particle(scene));
    const Mask none{};
    for_each(int(splat_blocks.size()), stage_deform, [&](int k, ThreadStats& c) {
        Tile<R> tiles[most_fields];
        int loaded = -1;
        Int3 corner{};
        for_each_splat(splat_blocks[std::size_t(k)], [&](Gaussian<R>& g) {
            if (g.still()) return;
            const Gaussian<R> start = g;
            c.splats_moved = true;
            const Int3 base = base_node(g.x, lattice.dx);
            const int block = lattice.block_of(base);
            const bool cut_here = !split.empty() && split[std::size_t(block)];
            if (block != loaded) {
                loaded = block, corner = 4 * lattice.block_at(block);
                for (int f = 0; f < (cut_here ? field_count() : 1); ++f)
                    load_tile(grid[f], lattice.block_at(block), tiles[f]);
            }
            const Node<R>* nodes = tiles[cut_here ? field_of(g.object, g.label()) : 0].node +
                                   tile_index(base - corner);
            const auto node = [&](Int3 step) {
                return node_share(nodes[tile_index(step)], per_mass);
            };
            if (!knead::deform(g, lattice.dx, lag.each<R>(), lag.substeps, node))
                c[Count::stranded] += lag.substeps;
            keep_within(g, walls);
            const bool tools = scene.passes > 0 && posed.near[std::size_t(block)];
            if (clear)
                c[Count::splats_projected] +=
                    knead::keep_out(g, colliders, tools ? posed.mask_at(lattice, g.x) : none,
                                    scene.passes, posed.blades, walls, lattice.dx);
            c[Count::splats_repaired] += repair(g, start);
        });
    });
    for (const ThreadStats& t : thread_stats) splats_arranged = splats_arranged && !t.splats_moved;
}

template <class R>
void CpuSolver<R>::set_gaussians(const std::vector<Gaussian<double>>& all)
{
    book.check_gaussians(all);
    std::vector<Gaussian<R>> next;
    for (const Gaussian<double>& g : all) next.push_back(cast<R>(g));
    time_deform(!next.empty());
    splats = std::move(next);
    splats_arranged = false, ++changes;
}

// Lists the stage that moves Gaussians among those timed, or not.
template <class R>
void CpuSolver<R>::time_deform(bool on)
{
    const bool timed = stage_times.back().name == "deform";
    if (timed && !on) stage_times.pop_back();
    if (!timed && on) stage_times.push_back({"deform", 0});
}

template <class R>
void CpuSolver<R>::edit_gaussians(const GaussianEdits& edits)
{
    check_edits(edits, splats.size(), q.size());
    book.check_placed(edits.placed);
    std::vector<int> places(edits.added.empty() ? 0 : q.size());
    for (std::size_t i = 0; i < places.size(); ++i) places[std::size_t(ids[i])] = int(i);
    const std::size_t wanted =
        splats.size() + edits.splits.size() + edits.added.size() + edits.placed.size();
    if (wanted > splats.capacity()) splats.reserve(wanted + wanted / 2);
    time_deform(wanted > 0);
    // From here on nothing throws.
    const WallOptions& between = scene.walls;
    for (const GaussianSplit& s : edits.splits)
        splats.push_back(knead::split(splats[std::size_t(s.index)], cast<R>(s.way), between));
    for (const GaussianBeside& b : edits.added) {
        const auto at = std::size_t(places[std::size_t(b.particle)]);
        splats.push_back(gaussian_beside(q[at], cast<R>(b.way), between));
    }
    for (const GaussianPlace& g : edits.placed)
        splats.push_back(gaussian_at(cast<R>(g.x), g.object));
    splats_arranged = false, ++changes;
}

template <class R>
std::vector<Gaussian<double>> CpuSolver<R>::gaussians() const
{
    return in_double(splats);
}

template void CpuSolver<float>::arrange_splats();
template void CpuSolver<float>::deform(const Lag&, bool);
template void CpuSolver<float>::time_deform(bool);
template void CpuSolver<float>::set_gaussians(const std::vector<Gaussian<double>>&);
template void CpuSolver<float>::edit_gaussians(const GaussianEdits&);
template std::vector<Gaussian<double>> CpuSolver<float>::gaussians() const;

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
