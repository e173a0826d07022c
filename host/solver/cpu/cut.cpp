// The loops that only a cut needs: three velocity fields near a blade, and whole pieces after it.
#include "cuda/mpm/grid.h"
#include "host/solver/cpu/solver.h"
#include "host/solver/pieces.h"

namespace knead {

// Marks all blocks as needing three fields, if anywhere both labels, or a blade, are near enough to
// share a node with clay of another. All: a labelled particle looks at its own field wherever it
// is.
template <class R>
bool CpuSolver<R>::find_splits()
{
    std::vector<char> labels(split.size(), 0);
    for (std::size_t slot = 0; slot < bins.occupied.size(); ++slot) {
        char& l = labels[std::size_t(bins.occupied[slot])];
        for (int i : bins.members(int(slot))) l = char(l | q[std::size_t(i)].label());
    }
    for (Int3 b : posed.masked)
        for_each_candidate(posed.masks[std::size_t(lattice.block_of(4 * b))], [&](int i) {
            if (posed.tools[std::size_t(posed.primitives[std::size_t(i)].tool)].blade)
                labels[std::size_t(lattice.block_of(4 * b))] = above | below;
        });
    const Int3 size = lattice.blocks();
    const auto seen_from = [&](Int3 at) {
        char all = 0;
        for (int n = 0; n < 27; ++n) {
            const Int3 m = at + Int3{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
            if (m.x >= 0 && m.y >= 0 && m.z >= 0 && m.x < size.x && m.y < size.y && m.z < size.z)
                all = char(all | labels[std::size_t(lattice.block_of(4 * m))]);
        }
        return all;
    };
    const bool any = std::any_of(bins.occupied.begin(), bins.occupied.end(), [&](int b) {
        return seen_from(lattice.block_at(b)) == (above | below);
    });
    std::fill(split.begin(), split.end(), char(any));
    return any;
}

// A block near a cut: each label has its own velocity, and the two do not pass through each other.
template <class R>
void CpuSolver<R>::split_update(int b, R dt, Counts& c)
{
    const R light = R(trifle(setup));
    const Colliders<R> colliders = posed.colliders();
    const Mask& mask = posed.masks[std::size_t(b)];
    const Int3 block = lattice.block_at(b);
    for (int l = 0; l < block_nodes; ++l) {
        const Int3 n = 4 * block + Int3{l % 4, l / 4 % 4, l / 16};
        Node<R> sum[3], v[3];
        for (int f = 0; f < 3; ++f) {
            const auto tools = [&](Vec3<R> x, Vec3<R> u) {
                if (!setup.grid_contact) return u;
                u = apply_tools(colliders, mask, x, u);
                return f ? sliced(colliders, mask, x, u, lattice.dx, std::uint32_t(f)) : u;
            };
            sum[f] = summed(sums[f], n);
            bool clipped;
            v[f] = update(sum[f], n, lattice, walls, gravity, dt, clipped, tools);
            if (clipped) ++(sum[f].m > light ? c.clipped : c.trimmed);
        }
        const R mass[3] = {sum[0].m, sum[above].m, sum[below].m};
        divide(v, mass, [&] {
            return slope(lattice, n, [&](Int3 m) {
                return summed(sums[below], m).m - summed(sums[above], m).m;
            });
        });
        for (int f = 0; f < 3; ++f) grid[f][std::size_t(b) * block_nodes + std::size_t(l)] = v[f];
    }
}

// At the end of a frame: a stroke that begins forgets old labels in its way, one that has ended
// leaves whole pieces.
template <class R>
void CpuSolver<R>::finish_cuts(bool covered)
{
    if (stillness.any() && covered != was_covered)
        for (Particle<R>& p : q) p.hold(false);  // whoever looks at whole pieces reads plain labels
    relabel_pieces(q, splats, lattice, posed, covered, was_covered);
    was_covered = covered;
}

template bool CpuSolver<float>::find_splits();
template void CpuSolver<float>::split_update(int, float, Counts&);
template void CpuSolver<float>::finish_cuts(bool);

}  // namespace knead
