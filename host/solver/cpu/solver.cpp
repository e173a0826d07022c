// The stages of host/solver/reference.cpp in order, vectorised and block by block. Bitwise
// deterministic for any number of threads: particles are binned by a stable sort, each block sums
// into a private tile, and each node adds the tiles around it in fixed order.
#include "host/solver/cpu/solver.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "cuda/mpm/grid.h"
#include "cuda/mpm/p2g.h"
#include "cuda/mpm/project.h"
#include "host/solver/cpu/transfer.h"
#include "host/solver/substep.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

template <class R>
CpuSolver<R>::CpuSolver(const Setup& given)
    : book(given),
      lattice{given.lattice.size, R(given.lattice.dx)},
      walls(walls_on<R>(given.lattice, given.walls)),
      gravity(cast<R>(given.gravity)),
      threads(given.threads > 0 ? given.threads : loop_threads()),
      posed(book.config(), lattice),
      stillness(given.rest, lattice)
{
    for (const Particle<double>& p : given.particles) q.push_back(cast<R>(p));
    for (const Gaussian<double>& g : given.gaussians) splats.push_back(cast<R>(g));
    renumber();
    apply_config();
    thread_stats.resize(std::size_t(threads));
}

template <class R>
FrameStats CpuSolver<R>::advance(const Motion& motion, double duration)
{
    FrameStats stats;
    for (StageTime& t : stage_times) t.seconds = 0;
    for (ThreadStats& t : thread_stats) t = {};
    const StepLimits limits = step_limits(scene);
    pushout = cast<R>(pushout_limits(limits));
    const bool tools = !posed.bindings.empty();
    const double tool_dt = tool_step(scene, motion, duration);
    const int bound = take_substep_bound();
    posed.activate(motion);

    const auto node = [&](const Particle<R>& p) {
        return lattice.index(base_node(p.x, lattice.dx));
    };
    if (!arranged) bins.reorder(q, ids, lattice.block_count(), node, threads);
    arrange_splats();
    if (stillness.any()) update_activity(motion);

    Lag lag{};
    Step step = step_at(limits, 0, most, tool_dt, duration);
    while (step.dt > 0) {
        const Step next = step_after(step, limits, most, tool_dt, duration);
        const double from = step.start / duration, to = next.start / duration;
        const R dt = R(step.dt);
        double start = wall_seconds();
        if (tools) {
            posed.pose(motion, from, to, step.dt);
            posed.mask_blocks(lattice);
        }
        stage_times[stage_pose].seconds += wall_seconds() - start;
        start = wall_seconds();
        bins.fill(lattice.block_count(), lattice.blocks(), threads);
        if (field_count() > 1) find_splits();
        stage_times[stage_bin].seconds += wall_seconds() - start;
        p2g(dt);
        grid_update(dt);
        g2p(dt);
        count(step, stats), lag.add(step.dt);
        const bool last = !(next.dt > 0) || ends_here(next.start, duration, stats, bound);
        if (lag.due() || last)
            deform(lag, last || clears_each_time(posed.blades, duration, tool_dt)), lag = {};
        if (stillness.any()) wake_roused(stats);
        take_extremes();
        if (last) break;
        step = next;
    }
    ThreadStats all;
    for (const ThreadStats& t : thread_stats) all.add(t);
    finish_cuts(all[Count::covered] > 0), finish_bodies(stats);
    all.put_into(stats, double(pushout.skin));
    stats.active_blocks = long(bins.reached.size()), stats.fastest = most.speed;
    arranged = all[Count::moved] == 0, ++changes;
    // The three particle stages of a block run in sequence on one thread: divide the wall time in
    // proportion to their sampled stage_times.
    const double inner =
        all.seconds[stage_g2p] + all.seconds[stage_project] + all.seconds[stage_plasticity];
    const double wall = stage_times[stage_g2p].seconds;
    if (inner > 0)
        for (int s : {stage_g2p, stage_project, stage_plasticity})
            stage_times[std::size_t(s)].seconds = wall * all.seconds[s] / inner;
    return stats;
}

// Calls visit(group) for the members, up to one particle per lane at a time.
template <class R>
template <class Visit>
void CpuSolver<R>::for_each_group(Bins::Members members, Visit&& visit)
{
    Group<R> group;
    for (const int* next = members.from; next < members.to;) {
        for (group.size = 0; group.size < Group<R>::count; ++group.size) {
            if (next == members.to || !group.takes(q[std::size_t(*next)])) break;
            group.index[group.size] = *next;
            group.of[group.size] = &q[std::size_t(*next++)];
        }
        for (int l = group.size; l < Group<R>::count; ++l)
            group.of[l] = group.of[group.size - 1], group.index[l] = group.index[group.size - 1];
        visit(group);
    }
}

// Each occupied block sums its particles into a private tile. Consecutive particles are mostly of
// one cell: its sum stays in registers.
template <class R>
void CpuSolver<R>::p2g(R dt)
{
    for (int f = 0; f < field_count(); ++f) sums[f].resize(bins.occupied.size());
    for_each(int(bins.occupied.size()), stage_p2g, [&](int slot, ThreadStats&) {
        const int block = bins.occupied[std::size_t(slot)];
        const bool split_here = !split.empty() && split[std::size_t(block)],
                   apart = split_here && bodies.colours > 0;
        if (split_here && !apart) return scatter_cut(slot, dt);
        for (int f = 0; f < (apart ? field_count() : 1); ++f) sums[f][std::size_t(slot)] = {};
        Node<R>*const all = sums[0][std::size_t(slot)].node, *field = all;
        const Int3 corner = 4 * lattice.block_at(block);
        // The sum of a cell continues across groups: it must not depend on the number of lanes.
        Row<R> cell[9] = {};
        int at = 0;
        const auto hand_over = [&](int to) __attribute__((always_inline))
        {
            UNROLL
            for (int n = 0; n < 9; ++n) {
                const int from = to + tile_index({0, n % 3, n / 3});
                knead::add(cell[n], all + from);
                if (field != all) knead::add(cell[n], field + from);  // of the body
                cell[n] = {};
            }
        };
        for_each_group(bins.members(slot), [&](const Group<R>& group) {
            Material<R> room;
            const Impulses<R> from =
                impulses(group, stillness.felt(*group.of[0], materials, room),
                         stillness.rise(*group.of[0], gravity, dt), lattice.dx, dt);
            for (int l = 0; l < group.size; ++l) {
                const Stencil<R> s = from.stencils[l];
                const int to = tile_index(s.base - corner);
                const Particle<R>& p = *group.of[l];
                Node<R>* const own =
                    apart ? sums[field_of(p.object, p.label())][std::size_t(slot)].node : all;
                if (to != at || own != field) hand_over(at), at = to, field = own;
                scatter_rows(from.base[l], from.by_x[l], from.by_y[l], from.by_z[l], s,
                             [&](int j, int k, const Row<R>& share) {
                                 cell[3 * k + j] = cell[3 * k + j] + share;
                             });
            }
        });
        hand_over(at);
    });
}

// Blocks near a blade scatter into three tiles: all clay, and per label the clay of this label and
// uncut clay.
template <class R>
void CpuSolver<R>::scatter_cut(int slot, R dt)
{
    for (int f = 0; f < 3; ++f) sums[f][std::size_t(slot)] = {};
    const Int3 corner = 4 * lattice.block_at(bins.occupied[std::size_t(slot)]);
    for (int i : bins.members(slot)) {
        Particle<R> p = q[std::size_t(i)];
        p.v = p.v + stillness.rise(p, gravity, dt);
        Material<R> room;
        const Stencil<R> s = stencil(p.x, lattice.dx);
        scatter(p, stillness.felt(p, materials, room), s, lattice.dx, dt,
                [&](Int3 step, const Node<R>& share) {
                    const int n = tile_index(s.base + step - corner);
                    for (std::uint32_t f :
                         {std::uint32_t(uncut), std::uint32_t(above), std::uint32_t(below)}) {
                        Node<R>& to = sums[f][std::size_t(slot)].node[n];
                        if (f == uncut || p.label() != opposite(f))
                            to = node(four(to) + four(share));
                    }
                });
    }
}

// Sums a block's nodes over the tiles of up to eight blocks whose particles reach it, in the order
// of summed().
template <class R>
void CpuSolver<R>::sum_block(Int3 block, Node<R>* sum) const
{
    for (int n = 0; n < 8; ++n) {
        const Int3 back = {n & 1, n >> 1 & 1, n >> 2}, from = block - back;
        if (from.x < 0 || from.y < 0 || from.z < 0) continue;
        const int slot = bins.slot[std::size_t(lattice.block_of(4 * from))];
        if (slot < 0) continue;
        const Node<R>* tile = sums[0][std::size_t(slot)].node + tile_index(4 * back);
        for (int z = 0; z < (back.z ? 2 : 4); ++z)
            for (int y = 0; y < (back.y ? 2 : 4); ++y)
                for (int x = 0; x < (back.x ? 2 : 4); ++x) {
                    Node<R>& to = sum[(z * 4 + y) * 4 + x];
                    to = node(four(to) + four(tile[tile_index({x, y, z})]));
                }
    }
}

template <class R>
void CpuSolver<R>::grid_update(R dt)
{
    const Colliders<R> colliders = posed.colliders();
    const R light = R(negligible_mass(scene));
    ++substeps;
    for_each(int(bins.reached.size()), stage_grid, [&](int t, ThreadStats& c) {
        const int b = bins.reached[std::size_t(t)];
        if (!split.empty() && split[std::size_t(b)]) return split_update(b, dt, c);
        const Int3 block = lattice.block_at(b);
        const Mask& mask = posed.masks[std::size_t(b)];
        const bool contact = scene.grid_contact && posed.near[std::size_t(b)];
        const auto hands = [&](Vec3<R> x, Vec3<R> v) {
            return contact ? apply_tools(colliders, mask, x, v) : v;
        };
        Node<R> sum[block_nodes] = {};
        sum_block(block, sum);
        const bool at_wall = beside_wall(4 * block);
        for (int l = 0; l < block_nodes; ++l) {
            const Int3 n = 4 * block + Int3{l % 4, l / 4 % 4, l / 16};
            const MirrorSet how = at_wall ? updated(n, sum[l].m) : MirrorSet{};
            if (how.is_mirror) continue;
            if (mirror_count(how.mirror_offset) > 1) {
                update_mirror_set(b, n, how.mirror_offset, dt, c);
                continue;
            }
            bool clipped;
            grid[0][std::size_t(b) * block_nodes + std::size_t(l)] =
                update(sum[l], n, lattice, walls, gravity, dt, clipped, hands, slides(0),
                       [&](Int3 m) { return summed(sums[0], m).m; });
            if (clipped) ++c[sum[l].m > light ? Count::clipped : Count::clipped_negligible];
        }
    });
}

// Loads the nodes that a block's particles can reach.
template <class R>
void CpuSolver<R>::load_tile(const std::vector<Node<R>>& from, Int3 block, Tile<R>& tile) const
{
    const Int3 size = lattice.blocks();
    for (int n = 0; n < 8; ++n) {
        const Int3 ahead = {n & 1, n >> 1 & 1, n >> 2}, b = block + ahead;
        if (b.x >= size.x || b.y >= size.y || b.z >= size.z) continue;
        const Node<R>* nodes = &from[std::size_t(lattice.index(4 * b))];
        Node<R>* to = tile.node + tile_index(4 * ahead);
        static constexpr Node<R> none[block_nodes]{};
        if (!bins.reaches(lattice.block_of(4 * b))) nodes = none;  // near a Gaussian only: no mass
        for (int z = 0; z < (ahead.z ? 2 : 4); ++z)
            for (int y = 0; y < (ahead.y ? 2 : 4); ++y)
                std::memcpy(to + tile_index({0, y, z}), nodes + (z * 4 + y) * 4,
                            ahead.x ? 2 * sizeof *to : 4 * sizeof *to);
    }
}

template <class R>
void CpuSolver<R>::g2p(R dt)
{
    for_each(int(bins.occupied.size()), stage_g2p, [&](int slot, ThreadStats& c) {
        const int block = bins.occupied[std::size_t(slot)];
        const bool held_here = stillness.holds(block);
        Bins::Members members = bins.members(slot);
        std::vector<int> movers;
        if (held_here) members = movers_among(members, movers);
        if (held_here && movers.empty() && !stillness.feels(block)) return;
        Tile<R> tiles[most_fields];
        const bool cut_here = !split.empty() && split[std::size_t(block)];
        for (int f = 0; f < (cut_here ? field_count() : 1); ++f)
            load_tile(grid[f], lattice.block_at(block), tiles[f]);
        if (held_here && (!movers.empty() || pushes(slot, dt, tiles)))
            stillness.roused[std::size_t(block)] = 1;
        if (shared_pressure) share_pressure(slot, members);
        step_particles(slot, members, dt, tiles, c);
    });
}

// Processes a block's particles group by group: gather and move, project, return map. Times of the
// three stages are sampled in every eighth block.
template <class R>
void CpuSolver<R>::step_particles(int slot, Bins::Members members, R dt, const Tile<R>* tiles,
                                  ThreadStats& c)
{
    c[Count::moved] += long(members.size());
    const int block = bins.occupied[std::size_t(slot)];
    const bool cut_here = !split.empty() && split[std::size_t(block)];
    const Int3 corner = 4 * lattice.block_at(block);
    double clock = 0;
    const auto lap = [&](int stage) {
        if (slot % 8 != 0) return;
        const double now = wall_seconds();
        if (stage >= 0) c.seconds[stage] += now - clock;
        clock = now;
    };
    for_each_group(members, [&](const Group<R>& group) {
        lap(-1);
        Start before[Group<R>::count];
        for (int l = 0; l < group.size; ++l) before[l] = {group.of[l]->x, group.of[l]->sides};
        const Material<R>& m = materials[std::size_t(group.of[0]->object)];
        Moved<R> moved = gather_and_move(group, m.mass, lattice.dx, dt, [&](int l, Int3 base) {
            return tiles[cut_here ? field_of(group.of[l]->object, group.of[l]->label()) : 0].node +
                   tile_index(base - corner);
        });
        Particle<Lanes<R>>& p = moved.p;
        lap(stage_g2p);
        Each<R> depth{};  // penetration into tools
        bool stale = keep_out(group, moved.per_cell, block, dt, depth, c);
        lap(stage_project);
        const unsigned yielding = near_yield_mask(p, m) & ((1u << group.size) - 1);
        for (unsigned left = yielding; left; left &= left - 1)
            c[Count::yielded] += yield(*group.of[lowest_bit(left)], m, dt);
        if (stale || yielding) p = knead::load(group);
        if (!sound(p)) {
            for (int l = 0; l < group.size; ++l) {
                Particle<R>& one = *group.of[l];
                c[Count::repaired] +=
                    repair(one, {before[l].x, {}, {}, {}, 0, one.object, before[l].sides});
            }
            p = knead::load(group);
        }
        const Each<R> speed_squared(dot(p.v, p.v));
        for (int l = 0; l < group.size; ++l) {
            c.speed_squared = std::max(c.speed_squared,
                                       double(speed_that_counts(speed_squared.of[l], depth.of[l])));
            c[Count::abrupt] += abrupt(group.of[l]->C, dt);
            c.stiffness = std::max(c.stiffness, double(stiffness(*group.of[l], m)));
        }
        note_blocks(group, p.x);
        lap(stage_plasticity);
    });
}

// Projects out of tools and walls if the block is near any; returns true if a particle may have
// changed.
template <class R>
bool CpuSolver<R>::keep_out(const Group<R>& group, const Each<R>& per_cell, int block, R dt,
                            Each<R>& depth, ThreadStats& c)
{
    const bool tools = scene.passes > 0 && posed.near[std::size_t(block)];
    const Int3 corner = 4 * lattice.block_at(block);
    if (!tools && !beside_wall(corner)) return false;
    const Colliders<R> colliders = posed.colliders();
    for (int l = 0; l < group.size; ++l) {
        Particle<R>& p = *group.of[l];
        if (tools) {
            const Mask& mask = posed.mask_at(lattice, p.x);
            if (posed.blades) c[Count::covered] += cut(p, colliders, mask, lattice.dx, c.touched);
            const R found =
                project(p, colliders, mask, scene.passes, pushout, per_cell.of[l], dt, c.touched);
            c[Count::projected] += found > 0, c[Count::moved_far] += found > lattice.dx;
            c.depth = std::max(c.depth, double(found)), depth.of[l] = found;
        }
        c[Count::confined] += confine(p, walls);
    }
    return true;
}

// Updates the block of each particle.
template <class R>
[[gnu::always_inline]] inline void CpuSolver<R>::note_blocks(const Group<R>& group,
                                                             const Vec3<Lanes<R>>& place)
{
    constexpr int count = Group<R>::count;
    const Each<R> x(place.x), y(place.y), z(place.z);
    alignas(vector_bytes) int block[count];
    for (int l = 0; l < count; ++l)
        block[l] = lattice.block_of(base_node(Vec3<R>{x.of[l], y.of[l], z.of[l]}, lattice.dx));
    for (int l = 0; l < count; ++l) bins.key[std::size_t(group.index[l])] = block[l];
}

template <class R>
std::size_t CpuSolver<R>::memory() const
{
    std::size_t bytes = 0;
    for (int f = 0; f < most_fields; ++f)
        bytes += sums[f].capacity() * sizeof(Tile<R>) + grid[f].capacity() * sizeof(Node<R>);
    return q.capacity() * (sizeof(Particle<R>) + 3 * sizeof(int)) +
           splats.capacity() * (sizeof(Gaussian<R>) + sizeof(int)) +
           posed.masks.capacity() * sizeof(Mask) + bytes;
}

template void CpuSolver<float>::load_tile(const std::vector<Node<float>>&, Int3,
                                          Tile<float>&) const;

#ifndef __clang__
// All else is local to its level (CMakeLists.txt: -fwhole-program).
[[gnu::externally_visible]] std::unique_ptr<EditableSimulator> plain_cpu_solver(const Setup& setup);
#endif
std::unique_ptr<EditableSimulator> plain_cpu_solver(const Setup& setup)
{
    return std::make_unique<CpuSolver<float>>(setup);
}

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
