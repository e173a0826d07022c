// Connected pieces of each object's clay: counted on the device, by five launches and one wait.
#include "cuda/device/copy.cuh"
#include "cuda/mpm/pieces.cuh"
#include "host/solver/gpu/solver.cuh"
#include "host/solver/gpu/store.cuh"
#include "host/solver/piece_count.h"

namespace knead::gpu {
namespace {

template <class T>
void clear(const DeviceArray<T>& array, std::size_t count, cudaStream_t stream)
{
    check(cudaMemsetAsync(array.data(), 0, count * sizeof(T), stream), "pieces");
}

}  // namespace

std::vector<int> GpuSolver::piece_counts(std::span<const int> group, int groups) const
{
    check_idle();
    if (store.count() == 0 || groups == 0) return std::vector<int>(std::size_t(groups), 0);
    if (groups > most_groups) return EditableSimulator::piece_counts(group, groups);
    const std::size_t places = std::size_t(piece_places(store.count()));
    PieceSpace& space = piece_space;
    reserve(space.keys, places), reserve(space.sums, places);
    reserve(space.parents, places), reserve(space.sizes, places);
    // The counts, and behind them whether the table is full.
    reserve(space.counts, std::size_t(groups) + 1), reserve(space.group, group.size());
    clear(space.keys, places, main), clear(space.sums, places, main);
    clear(space.counts, std::size_t(groups) + 1, main);
    check(cudaMemcpyAsync(space.group.data(), group.data(), group.size_bytes(), cudaMemcpyDefault,
                          main),
          "pieces");
    const Views& views = store.views();
    const float dx = views.lattice.dx;
    const PieceTable table{space.keys.data(),           space.sums.data(), space.parents.data(),
                           space.sizes.data(),          int(places),       space.counts.data(),
                           space.counts.data() + groups};
    const PieceLimits limits{1 / (dx * dx * dx), unsigned(filled_share * 65536),
                             int(fewest_particles_in_part), int(group.size())};
    count_pieces(read_only(views.particles[side]), views.materials, views.lattice,
                 space.group.data(), limits, table, main);
    std::vector<int> counts(std::size_t(groups) + 1);
    check(cudaMemcpyAsync(counts.data(), space.counts.data(), counts.size() * sizeof(int),
                          cudaMemcpyDefault, main),
          "pieces");
    wait(main, "pieces");
    const bool full = counts.back() != 0;
    counts.pop_back();
    return full ? EditableSimulator::piece_counts(group, groups) : counts;
}

}  // namespace knead::gpu
