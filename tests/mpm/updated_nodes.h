// The grid update by a plain loop: every node with its images behind walls.
#pragma once
#include <vector>

#include "cuda/mpm/grid.h"

namespace knead {

// Velocities from sums; tools(x, v) answers with what the tools near x leave of v.
template <class R, class Tools>
std::vector<Node<R>> updated_nodes(const std::vector<Node<R>>& sums, const Lattice<R>& lattice,
                                   const Walls<R>& walls, Vec3<R> gravity, R dt, Tools&& tools)
{
    std::vector<Node<R>> out(sums.size());
    const auto index = [&](Int3 n) { return std::size_t(lattice.index(n)); };
    for (int i = 0; i < lattice.node_count(); ++i) {
        const Int3 n = lattice.node_at(i);
        const MirrorSet how = mirror_set(
            n, walls, [&](Int3 mirror_offset) { return sums[index(n + mirror_offset)].m; });
        if (!(sums[index(n)].m > 0) || how.is_mirror) continue;
        const int count = mirror_count(how.mirror_offset);
        Node<R> together_with[8] = {};
        for (int k = 0; k < count; ++k)
            together_with[k] = sums[index(mirror_node(n, how.mirror_offset, k))];
        update_mirrors(
            n, how.mirror_offset, lattice, walls, gravity, dt, InArray<R>{together_with},
            [&](Vec3<R>& v) {
                const Vec3<R> free = v;
                v = tools(lattice.position(n), v);
                return differ(v, free);
            },
            [](R) {}, Forgotten<R>{}, [&](Int3 m) { return sums[index(m)].m; });
        for (int k = 0; k < count; ++k)
            out[index(mirror_node(n, how.mirror_offset, k))] = together_with[k];
    }
    return out;
}

}  // namespace knead
