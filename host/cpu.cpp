// Every stage of the substep as a plain loop, in order: the specification, the fallback without a
// GPU, and, in double, the oracle. The same bits for any number of threads: particles are binned
// stably by block, a block's sums are private, and each node adds its neighbours' in fixed order.
#include <algorithm>
#include <cstring>
#include <numeric>

#include "cpu_solver.h"
#include "cuda/g2p.h"
#include "cuda/grid.h"
#include "cuda/p2g.h"
#include "cuda/plasticity.h"
#include "cuda/project.h"
#include "substep.h"

namespace knead {
template <class R>
CpuSolver<R>::CpuSolver(const Setup& given)
    : setup(given),
      lattice{given.lattice.size, R(given.lattice.dx)},
      walls{given.walls.margin, given.walls.touch, R(given.walls.friction)},
      gravity(cast<R>(given.gravity)),
      threads(given.threads > 0 ? given.threads : omp_get_max_threads()),
      posed(given, lattice)
{
    for (const Material<double>& m : setup.materials) materials.push_back(cast<R>(m));
    for (const Particle<double>& p : setup.particles) q.push_back(cast<R>(p));
    setup.particles.clear();
    ids.resize(q.size());
    std::iota(ids.begin(), ids.end(), 0);
    for (int f = 0; f < (posed.blades ? 3 : 1); ++f)
        grid[f].resize(std::size_t(lattice.node_count()));
    if (posed.blades) split.resize(std::size_t(lattice.block_count()));
    counts.resize(std::size_t(threads));
    for (const char* name : {"pose", "bin", "p2g", "grid", "g2p", "project", "plasticity"})
        times.push_back({name, 0});
}

template <class R>
Tally CpuSolver<R>::advance(const Motion& motion, double duration)
{
    Tally tally;
    for (StageTime& t : times) t.seconds = 0;
    for (Counts& c : counts) c = {};
    double speed_squared = 0;
    for (const Particle<R>& p : q) speed_squared = std::max(speed_squared, double(dot(p.v, p.v)));
    const Pace pace = pace_of(setup);
    const bool tools = !posed.bindings.empty();
    const double tool_dt = tools ? tool_step(setup, motion, duration) : 1e30;
    posed.activate(motion);

    const auto key = [&](const Particle<R>& p) {
        return lattice.block_of(base_node(p.x, lattice.dx));
    };
    bins.reorder(q, ids, lattice.block_count(), key, threads);

    for (double done = 0; duration - done > 1e-12 * duration;) {
        const StepChoice step = paced(pace, std::sqrt(speed_squared), tool_dt, duration - done);
        const double from = done / duration;
        done += step.dt;
        const R dt = R(step.dt);
        double start = omp_get_wtime();
        if (tools) {
            posed.pose(motion, from, done / duration, step.dt);
            posed.mask_blocks(lattice);
        }
        times[stage_pose].seconds += omp_get_wtime() - start;
        start = omp_get_wtime();
        bins.fill(q, lattice.block_count(), key, lattice.blocks(), threads);
        if (posed.blades) find_splits();
        times[stage_bin].seconds += omp_get_wtime() - start;
        p2g(dt);
        grid_update(dt);
        g2p(dt);

        speed_squared = 0;
        for (Counts& c : counts)
            speed_squared = std::max(speed_squared, c.speed_squared), c.speed_squared = 0;
        tally.dt_least = tally.substeps ? std::min(tally.dt_least, step.dt) : step.dt;
        tally.dt_most = std::max(tally.dt_most, step.dt);
        ++tally.limits[int(step.limit)];
        ++tally.substeps;
    }
    Counts all;
    for (const Counts& c : counts) all.add(c);
    if (posed.blades) settle_cuts(all.covered > 0);
    tally.yielded = all.yielded, tally.projected = all.projected, tally.clipped = all.clipped;
    tally.confined = all.confined, tally.repaired = all.repaired, tally.found_depth = all.depth;
    tally.active_blocks = long(bins.touched.size());
    // The particle loops of a block run one after the other on one thread: share out their time.
    const double inner =
        all.seconds[stage_g2p] + all.seconds[stage_project] + all.seconds[stage_plasticity];
    const double wall = times[stage_g2p].seconds;
    if (inner > 0)
        for (int s : {stage_g2p, stage_project, stage_plasticity})
            times[std::size_t(s)].seconds = wall * all.seconds[s] / inner;
    return tally;
}

// Each occupied block sums its particles into a tile of its own; where a blade has been, into
// three.
template <class R>
void CpuSolver<R>::p2g(R dt)
{
    for (int f = 0; f < (posed.blades ? 3 : 1); ++f)
        sums[f].resize(bins.occupied.size() * tile_nodes);
    for_each(int(bins.occupied.size()), stage_p2g, [&](int slot, Counts&) {
        const int block = bins.occupied[std::size_t(slot)];
        const int fields = !split.empty() && split[std::size_t(block)] ? 3 : 1;
        Node<R>* tile[3];
        for (int f = 0; f < fields; ++f) {
            tile[f] = &sums[f][std::size_t(slot) * tile_nodes];
            std::memset(static_cast<void*>(tile[f]), 0, tile_nodes * sizeof(Node<R>));
        }
        const Int3 corner = 4 * lattice.block_at(block);
        for (int i : bins.members(slot)) {
            const Particle<R>& p = q[std::size_t(i)];
            const Stencil<R> s = stencil(p.x, lattice.dx);
            const int base = tile_index(s.base - corner);
            const auto add = [&](Node<R>* to, Int3 step, const Node<R>& share) {
                Node<R>& n = to[base + tile_index(step)];
                n = node(four(n) + four(share));
            };
            const Material<R>& m = materials[std::size_t(p.object)];
            if (fields == 1) {
                scatter(p, m, s, lattice.dx, dt,
                        [&](Int3 step, const Node<R>& share) { add(tile[0], step, share); });
                continue;
            }
            scatter(p, m, s, lattice.dx, dt, [&](Int3 step, const Node<R>& share) {
                add(tile[0], step, share);
                if (p.sides != below) add(tile[above], step, share);
                if (p.sides != above) add(tile[below], step, share);
            });
        }
    });
}

template <class R>
void CpuSolver<R>::grid_update(R dt)
{
    const Colliders<R> colliders = posed.colliders();
    for_each(int(bins.touched.size()), stage_grid, [&](int t, Counts& c) {
        const int b = bins.touched[std::size_t(t)];
        if (!split.empty() && split[std::size_t(b)]) return split_update(b, dt, c);
        const Int3 block = lattice.block_at(b);
        const Mask& mask = posed.masks[std::size_t(b)];
        const auto hands = [&](Vec3<R> x, Vec3<R> v) {
            return setup.grid_contact ? held(colliders, mask, x, v) : v;
        };
        for (int l = 0; l < block_nodes; ++l) {
            const Int3 n = 4 * block + Int3{l % 4, l / 4 % 4, l / 16};
            bool clipped;
            grid[0][std::size_t(b) * block_nodes + std::size_t(l)] =
                update(summed(sums[0], n), n, lattice, walls, gravity, dt, clipped, hands);
            c.clipped += clipped;
        }
    });
}

// The nodes that a block's particles can reach.
template <class R>
void CpuSolver<R>::load(const Sums& from, Int3 corner, Node<R>* tile) const
{
    for (int t = 0; t < tile_nodes; ++t) {
        const Int3 n =
            corner + Int3{t % tile_edge, t / tile_edge % tile_edge, t / (tile_edge * tile_edge)};
        if (n.x < lattice.size.x && n.y < lattice.size.y && n.z < lattice.size.z)
            tile[t] = from[std::size_t(lattice.index(n))];
    }
}

template <class R>
void CpuSolver<R>::g2p(R dt)
{
    for_each(int(bins.occupied.size()), stage_g2p, [&](int slot, Counts& c) {
        const int block = bins.occupied[std::size_t(slot)];
        Node<R> tiles[3][tile_nodes];
        const Int3 corner = 4 * lattice.block_at(block);
        const bool cut_here = !split.empty() && split[std::size_t(block)];
        for (int f = 0; f < (cut_here ? 3 : 1); ++f) load(grid[f], corner, tiles[f]);
        step_particles(slot, dt, tiles, c);
    });
}

// A block's particles: gather and move, then project, then flow.
template <class R>
void CpuSolver<R>::step_particles(int slot, R dt, const Node<R> (*tiles)[tile_nodes], Counts& c)
{
    const int block = bins.occupied[std::size_t(slot)];
    const Int3 corner = 4 * lattice.block_at(block);
    const bool cut_here = !split.empty() && split[std::size_t(block)];
    const auto members = bins.members(slot);
    std::vector<Particle<R>> before(members.size());
    double clock = omp_get_wtime();
    const auto lap = [&](StageName s) {
        const double now = omp_get_wtime();
        c.seconds[s] += now - clock;
        clock = now;
    };
    std::size_t k = 0;
    for (int i : members) {
        Particle<R>& p = q[std::size_t(i)];
        before[k++] = p;
        const Stencil<R> s = stencil(p.x, lattice.dx);
        const Node<R>* base = tiles[cut_here ? p.sides : 0] + tile_index(s.base - corner);
        gather(p, s, lattice.dx, [&](Int3 step) { return four(base[tile_index(step)]); });
        p.e = strained(p.e, p.C, dt);
        p.x = p.x + dt * p.v;
    }
    lap(stage_g2p);
    const Colliders<R> colliders = posed.colliders();
    for (int i : members) {
        Particle<R>& p = q[std::size_t(i)];
        if (setup.passes > 0 && !posed.masked.empty()) {
            const Mask& mask = posed.mask_at(lattice, p.x);
            if (posed.blades) c.covered += cut(p, colliders, mask, lattice.dx);
            const R depth = project(p, colliders, mask, setup.passes);
            c.projected += depth > 0;
            c.depth = std::max(c.depth, double(depth));
        }
        c.confined += confine(p, lattice, walls);
    }
    lap(stage_project);
    k = 0;
    for (int i : members) {
        Particle<R>& p = q[std::size_t(i)];
        c.yielded += yield(p, materials[std::size_t(p.object)], dt);
        c.repaired += repair(p, before[k++]);
        c.speed_squared = std::max(c.speed_squared, double(dot(p.v, p.v)));
    }
    lap(stage_plasticity);
}

template <class R>
std::vector<Particle<double>> CpuSolver<R>::particles() const
{
    std::vector<Particle<double>> all(q.size());
    for (std::size_t i = 0; i < q.size(); ++i) all[std::size_t(ids[i])] = cast<double>(q[i]);
    return all;
}

template <class R>
std::vector<double> CpuSolver<R>::penetration() const
{
    std::vector<double> depths;
    if (posed.masked.empty()) return depths;
    for (const Particle<R>& p : q) {
        const Contact<R> hit = nearest(posed.colliders(), posed.mask_at(lattice, p.x), p.x);
        if (hit.phi < 0) depths.push_back(double(-hit.phi));
    }
    return depths;
}

template <class R>
std::size_t CpuSolver<R>::memory() const
{
    std::size_t nodes = 0;
    for (int f = 0; f < 3; ++f) nodes += sums[f].capacity() + grid[f].capacity();
    return q.capacity() * (sizeof(Particle<R>) + 3 * sizeof(int)) +
           posed.masks.capacity() * sizeof(Mask) + nodes * sizeof(Node<R>);
}

const char* const limit_names[int(Limit::count)] = {"sound",     "speed", "tool",
                                                    "viscosity", "fixed", "frame end"};

double tool_step(const Setup& setup, const Motion& motion, double duration)
{
    double dt = 1e30;
    const double dx = setup.lattice.dx;
    for (const Primitive& p : setup.rig.primitives) {
        const auto tool = std::size_t(p.tool);
        if (tool < motion.active.size() && !motion.active[tool]) continue;
        for (int k = 0; k < p.count; ++k) {
            const Binding<float>& f = setup.rig.spheres[std::size_t(p.sphere[k])];
            const auto at = [&](const std::vector<Joint<double>>& joints) {
                Vec3<double> c{};
                for (int n = 0; n < 4; ++n) {
                    const Joint<double>& j = joints[std::size_t(f.joint[n])];
                    c = c + double(f.weight[n]) * (j.p + rotate(j.q, cast<double>(f.offset[n])));
                }
                return c;
            };
            const double way = length(at(motion.to) - at(motion.from));
            const double room = setup.tools[tool].blade ? dx : std::min(double(f.radius), dx);
            if (way > 0) dt = std::min(dt, setup.step.tool * room / way * duration);
        }
    }
    return dt;
}

std::unique_ptr<Solver> cpu_solver(const Setup& setup)
{
    return std::make_unique<CpuSolver<float>>(setup);
}
std::unique_ptr<Solver> cpu_solver_double(const Setup& setup)
{
    return std::make_unique<CpuSolver<double>>(setup);
}

}  // namespace knead
