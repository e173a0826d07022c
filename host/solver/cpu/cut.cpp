// Stages for walls and cuts: mirror images of nodes across walls, three velocity fields near a
// blade, relabelling of pieces.
#include "cuda/mpm/grid.h"
#include "host/solver/cpu/solver.h"
#include "host/solver/pieces.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

// Sets `split` for all blocks if anywhere clay of both labels, of two colours, or a blade, is close
// enough to share a node with clay of another label or colour. It is set for all blocks, because a
// labelled particle always gathers from its own field.
template <class R>
bool CpuSolver<R>::find_splits()
{
    constexpr int sides = above | below;  // then a bit for each colour
    std::vector<char> labels(split.size(), 0);
    const bool colours = bodies.colours > 0;
    for (std::size_t slot = 0; slot < bins.occupied.size(); ++slot) {
        char& l = labels[std::size_t(bins.occupied[slot])];
        for (int i : bins.members(int(slot))) {
            const Particle<R>& p = q[std::size_t(i)];
            l = char(l | p.label() | (colours ? 2u << bodies.colour[std::size_t(p.object)] : 0));
        }
    }
    for (Int3 b : posed.masked)
        for_each_candidate(posed.masks[std::size_t(lattice.block_of(4 * b))], [&](int i) {
            if (posed.tools[std::size_t(posed.primitives[std::size_t(i)].tool)].blade)
                labels[std::size_t(lattice.block_of(4 * b))] |= char(sides);
        });
    const Int3 size = lattice.blocks();
    const auto seen_from = [&](Int3 at) {
        char all = 0;
        for (int n = 0; n < 27; ++n) {
            const Int3 m = at + Int3{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
            if (within(m, size)) all = char(all | labels[std::size_t(lattice.block_of(4 * m))]);
        }
        return all;
    };
    const bool any = std::any_of(bins.occupied.begin(), bins.occupied.end(), [&](int b) {
        const int seen = seen_from(lattice.block_at(b));
        const int bodies_near = seen & ~sides;
        return (bodies_near & (bodies_near - 1)) != 0 || (seen & sides) == sides;
    });
    std::fill(split.begin(), split.end(), char(any));
    return any;
}

// The mirror set of a node with this mass.
template <class R>
MirrorSet CpuSolver<R>::updated(Int3 n, R mass) const
{
    if (!(mass > 0)) return {};
    return mirror_set(n, walls, [&](Int3 to) { return summed(sums[0], n + to).m; });
}

// The side of a blade on which field f of bodies is kept, of fields v at a node and its images;
// uncut: neither, as its clay there moves with uncut clay.
template <class R>
std::uint32_t CpuSolver<R>::sliced_side(const Node<R> (&v)[most_fields][8], int f) const
{
    const int label = (f - 1) % bodies.labels, first = f - label;
    if (label == 0) return uncut;
    const LabelledClay<R> clay{v[first][0].m, v[first + 1][0].m, v[first + 2][0].m};
    return clay.bridged() ? std::uint32_t(uncut) : std::uint32_t(label);
}

// Updates node n of block b and its mirror images across walls. Near a cut each label has its own
// velocity, and the labels do not interpenetrate (24), (25).
template <class R>
void CpuSolver<R>::update_mirror_set(int b, Int3 n, Int3 across, R dt, ThreadStats& c)
{
    const R light = R(negligible_mass(scene));
    const Colliders<R> colliders = posed.colliders();
    const Mask& mask = posed.masks[std::size_t(b)];
    const int count = mirror_count(across),
              fields = split.empty() || !split[std::size_t(b)] ? 1 : field_count();
    const bool apart = bodies.colours > 0 && fields > 1;
    Node<R> v[most_fields][8] = {};
    for (int f = 0; f < fields; ++f)
        for (int k = 0; k < count; ++k) v[f][k] = summed(sums[f], mirror_node(n, across, k));
    for (int k = 0; apart && k < count; ++k) {
        Node<R> one[most_fields];
        for (int f = 1; f < fields; ++f) one[f] = v[f][k];
        separate(mirror_node(n, across, k), one, dt);
        for (int f = 1; f < fields; ++f) v[f][k] = one[f];
    }
    for (int f = apart; f < fields; ++f) {
        const std::uint32_t side = apart ? sliced_side(v, f) : std::uint32_t(f);
        const auto tools = [&](Vec3<R>& u) {
            if (!scene.grid_contact || !posed.near[std::size_t(b)]) return false;
            const Vec3<R> x = lattice.position(n), free = u;
            u = apply_tools(colliders, mask, x, u);
            if (side != uncut) u = sliced(colliders, mask, x, u, lattice.dx, side);
            return differ(u, free);
        };
        update_mirrors(
            n, across, lattice, walls, gravity, dt, InArray<R>{v[f]}, tools,
            [&](R mass) { ++c[mass > light ? Count::clipped : Count::clipped_negligible]; },
            slides(f), [&](Int3 m) { return summed(sums[0], m).m; });
    }
    for (int k = 0; k < count; ++k) {
        const Int3 m = mirror_node(n, across, k);
        if (k && !(v[0][k].m > 0)) continue;  // updated with its own block
        if (apart) {                          // field 0: the mean velocity
            Node<R>& mean = grid[0][std::size_t(lattice.index(m))];
            mean = {};
            for (int first = 1; bodies.labels > 1 && first < fields; first += bodies.labels)
                weld_velocities<R>(
                    first, [&](int f) { return v[f][k]; },
                    [&](int f, const Node<R>& node) { v[f][k] = node; });
            for (int f = 1; f < fields; ++f) {
                const Node<R>& own = grid[f][std::size_t(lattice.index(m))] = v[f][k];
                mean = {mean.p + own.m * own.p, mean.m + own.m};
            }
            if (mean.m > 0) mean.p = (1 / mean.m) * mean.p;
            continue;
        }
        Node<R> one[3] = {v[0][k], v[1][k], v[2][k]};
        if (fields > 1)
            divide(one, {one[0].m, one[above].m, one[below].m}, [&] {
                return slope(lattice, m, [&](Int3 other) {
                    return summed(sums[below], other).m - summed(sums[above], other).m;
                });
            });
        for (int f = 0; f < fields; ++f) grid[f][std::size_t(lattice.index(m))] = one[f];
    }
}

// Contact of bodies at node n; fields[f]: its sums of momentum and mass.  (25a)
template <class R>
void CpuSolver<R>::separate(Int3 n, Node<R>* fields, R dt) const
{
    const auto mass = [&](int f, Int3 step) {
        if (step == Int3{}) return fields[f].m;
        return lattice.stores(n + step) ? summed(sums[f], n + step).m : R(0);
    };
    const auto momentum = [&](int f) { return fields[f].p; };
    const auto add = [&](int f, Vec3<R> impulse) { fields[f].p = fields[f].p + impulse; };
    if (body_constants.labels > 1)
        separate_fields<labels_of_clay>(body_constants, lattice.dx, dt, mass, momentum, add);
    else
        separate_fields<1>(body_constants, lattice.dx, dt, mass, momentum, add);
}

// Grid update of a block near a cut, or of bodies.
template <class R>
void CpuSolver<R>::split_update(int b, R dt, ThreadStats& c)
{
    const Int3 block = lattice.block_at(b);
    for (int l = 0; l < block_nodes; ++l) {
        const Int3 n = 4 * block + Int3{l % 4, l / 4 % 4, l / 16};
        const MirrorSet how = updated(n, summed(sums[0], n).m);
        if (!how.is_mirror) update_mirror_set(b, n, how.mirror_offset, dt, c);
    }
}

// Gives bodies that share colours those of where they are now. Returns whether a colour has
// changed: then what slides at walls was that of other clay.
template <class R>
bool CpuSolver<R>::recolour()
{
    if (!bodies.shared() || !bodies.colour_by(body_graph(q, lattice, bodies.body))) return false;
    body_constants = body_fields<R>(bodies, scene);
    return true;
}

template <class R>
void CpuSolver<R>::finish_bodies(FrameStats& stats)
{
    stats.welded_bodies = bodies.welded;
    if (recolour())
        for (auto& field : sliding) std::fill(field.begin(), field.end(), Sliding<R>{});
}

// End of a frame: the start of a stroke clears old labels near the blade; its end labels complete
// pieces.
template <class R>
void CpuSolver<R>::finish_cuts(bool covered)
{
    if (!posed.blades) return;
    if (stillness.any() && covered != was_covered)
        for (Particle<R>& p : q) p.hold(false);  // relabelling compares plain labels
    relabel_pieces(q, splats, lattice, bodies, posed, covered, was_covered);
    was_covered = covered;
}

template void CpuSolver<float>::separate(Int3, Node<float>*, float) const;
template bool CpuSolver<float>::find_splits();
template bool CpuSolver<float>::recolour();
template void CpuSolver<float>::finish_bodies(FrameStats&);
template MirrorSet CpuSolver<float>::updated(Int3, float) const;
template void CpuSolver<float>::update_mirror_set(int, Int3, Int3, float, ThreadStats&);
template void CpuSolver<float>::split_update(int, float, ThreadStats&);
template void CpuSolver<float>::finish_cuts(bool);

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
