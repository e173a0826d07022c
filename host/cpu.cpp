// Every stage of the substep as a plain loop, in order: the specification, the fallback without a
// GPU, and, in double, the oracle. The same bits for any number of threads: particles are binned
// stably by block, a block's sums are private, and each node adds its neighbours' in fixed order.
#include <omp.h>

#include <algorithm>
#include <cstring>
#include <numeric>

#include "cuda/blade.h"
#include "cuda/four.h"
#include "cuda/g2p.h"
#include "cuda/grid.h"
#include "cuda/p2g.h"
#include "cuda/plasticity.h"
#include "cuda/project.h"
#include "cpu_bins.h"
#include "cpu_tools.h"
#include "pieces.h"
#include "substep.h"

namespace knead {
namespace {

constexpr int tile_edge = block_edge + 2, tile_nodes = tile_edge * tile_edge * tile_edge;

int tile_index(Int3 n) { return (n.z * tile_edge + n.y) * tile_edge + n.x; }

template <class R>
Material<R> cast(const Material<double>& m)
{
    return {m.elasticity, m.flow, R(m.density), R(m.mu), R(m.lambda), R(m.bulk), R(m.yield),
            R(m.hardening), R(m.yield_floor), R(m.friction), R(m.cohesion), R(m.compress),
            R(m.stretch), R(m.snow), R(m.viscosity), R(m.exponent), R(m.mass), R(m.volume),
            m.category};
}

template <class To, class From>
Particle<To> cast(const Particle<From>& q)
{
    const auto c = [](Vec3<From> v) { return knead::cast<To>(v); };
    return {c(q.x), c(q.v), {c(q.C.a), c(q.C.b), c(q.C.c)},
            {To(q.e.xx), To(q.e.yy), To(q.e.zz), To(q.e.xy), To(q.e.xz), To(q.e.yz)},
            To(q.k), q.object, q.sides};
}

enum StageName { stage_pose, stage_bin, stage_p2g, stage_grid, stage_g2p, stage_project,
                 stage_plasticity, stage_count };

// What the threads count, each on its own.
struct Counts {
    long yielded = 0, projected = 0, clipped = 0, confined = 0, repaired = 0, covered = 0;
    double depth = 0, speed_squared = 0;
    double seconds[stage_count] = {};
    void add(const Counts& c)
    {
        yielded += c.yielded, projected += c.projected, clipped += c.clipped;
        confined += c.confined, repaired += c.repaired, covered += c.covered;
        depth = std::max(depth, c.depth), speed_squared = std::max(speed_squared, c.speed_squared);
        for (int s = 0; s < stage_count; ++s) seconds[s] += c.seconds[s];
    }
};

template <class R>
class CpuSolver : public Solver {
  public:
    explicit CpuSolver(const Setup& given);
    Tally advance(const Motion& motion, double duration) override;
    std::vector<Particle<double>> particles() const override;
    std::vector<double> penetration() const override;
    const std::vector<StageTime>& stage_times() const override { return times; }
    std::size_t memory() const override;
    std::string name() const override
    {
        return std::string("cpu ") + (sizeof(R) == 4 ? "float" : "double") + ", " +
               std::to_string(threads) + " threads";
    }

  private:
    using Sums = std::vector<Node<R>>;
    void p2g(R dt);
    void grid_update(R dt);
    void split_update(int b, R dt, Counts& counts);
    void g2p(R dt);
    Node<R> summed(const Sums& sums, Int3 node) const;
    void load(const Sums& from, Int3 corner, Node<R>* tile) const;
    void step_particles(int slot, R dt, const Node<R> (*tiles)[tile_nodes], Counts& counts);
    bool find_splits();
    void settle_cuts(bool covered);
    template <class Body>
    void for_each(int count, StageName stage, Body&& body);

    Setup setup;
    Lattice<R> lattice;
    Walls<R> walls;
    Vec3<R> gravity;
    int threads;
    std::vector<Material<R>> materials;
    PosedTools<R> posed;
    std::vector<Particle<R>> q;  // in the order of the last sort by block
    std::vector<int> ids;        // original index of q[i]
    Bins bins;
    // Three velocity fields: all clay, and where a blade has been (25) that of uncut and one label.
    // tile_nodes sums per occupied block; node_count velocities.
    Sums sums[3], grid[3];
    std::vector<char> split;     // per block: its nodes have three fields; empty without blades
    bool was_covered = false;    // a blade was in the clay at the end of the last frame
    std::vector<Counts> counts;   // per thread
    std::vector<StageTime> times;
};

template <class R>
CpuSolver<R>::CpuSolver(const Setup& given)
    : setup(given),
      lattice{given.lattice.size, R(given.lattice.dx)},
      walls{given.walls.margin, given.walls.touch, R(given.walls.friction)},
      gravity(knead::cast<R>(given.gravity)),
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

// Runs body(i, thread's counts) for i in [0, count) on all threads, and books the wall time.
template <class R>
template <class Body>
void CpuSolver<R>::for_each(int count, StageName stage, Body&& body)
{
    const double start = omp_get_wtime();
#pragma omp parallel for schedule(dynamic, 4) num_threads(threads)
    for (int i = 0; i < count; ++i) body(i, counts[std::size_t(omp_get_thread_num())]);
    times[stage].seconds += omp_get_wtime() - start;
}

template <class R>
Tally CpuSolver<R>::advance(const Motion& motion, double duration)
{
    Tally tally;
    for (StageTime& t : times) t.seconds = 0;
    for (Counts& c : counts) c = {};
    double speed_squared = 0;
    for (const Particle<R>& p : q) speed_squared = std::max(speed_squared, double(dot(p.v, p.v)));
    const bool tools = !posed.bindings.empty();
    const double tool_dt = tools ? tool_step(setup, motion, duration) : 1e30;
    posed.activate(motion);

    const auto key = [&](const Particle<R>& p) {
        return lattice.block_of(base_node(p.x, lattice.dx));
    };
    bins.reorder(q, ids, lattice.block_count(), key, threads);

    for (double done = 0; duration - done > 1e-12 * duration;) {
        const StepChoice step =
            step_length(setup, std::sqrt(speed_squared), tool_dt, duration - done);
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
    const double inner = all.seconds[stage_g2p] + all.seconds[stage_project] +
                         all.seconds[stage_plasticity];
    const double wall = times[stage_g2p].seconds;
    if (inner > 0)
        for (int s : {stage_g2p, stage_project, stage_plasticity})
            times[std::size_t(s)].seconds = wall * all.seconds[s] / inner;
    return tally;
}

// Each occupied block sums its particles into a tile of its own; where a blade has been, into three.
template <class R>
void CpuSolver<R>::p2g(R dt)
{
    for (int f = 0; f < (posed.blades ? 3 : 1); ++f) sums[f].resize(bins.occupied.size() * tile_nodes);
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
            scatter(p, materials[std::size_t(p.object)], s, lattice.dx, dt,
                    [&](Int3 step, const Node<R>& share) {
                        const int at = base + tile_index(step);
                        tile[0][at] = node(four(tile[0][at]) + four(share));
                        for (int f = 1; f < fields; ++f)
                            if (p.sides == uncut || int(p.sides) == f)
                                tile[f][at] = node(four(tile[f][at]) + four(share));
                    });
        }
    });
}

// Marks the blocks that need three fields: both labels, or a blade, near enough to share a node.
template <class R>
bool CpuSolver<R>::find_splits()
{
    std::vector<char> labels(split.size(), 0);
    bool any = false;
    for (std::size_t slot = 0; slot < bins.occupied.size(); ++slot) {
        char& l = labels[std::size_t(bins.occupied[slot])];
        for (int i : bins.members(int(slot))) l = char(l | q[std::size_t(i)].sides);
    }
    for (Int3 b : posed.masked)
        for_each_candidate(posed.masks[std::size_t(lattice.block_of(4 * b))], [&](int i) {
            if (posed.tools[std::size_t(posed.primitives[std::size_t(i)].tool)].blade)
                labels[std::size_t(lattice.block_of(4 * b))] = 3;
        });
    const Int3 size = lattice.blocks();
    std::fill(split.begin(), split.end(), char(0));
    for (std::size_t b = 0; b < split.size(); ++b) {
        if (!labels[b]) continue;
        const Int3 at = lattice.block_at(int(b));
        const auto near = [&](auto&& visit) {
            for (int n = 0; n < 27; ++n) {
                const Int3 m = at + Int3{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
                if (m.x >= 0 && m.y >= 0 && m.z >= 0 && m.x < size.x && m.y < size.y &&
                    m.z < size.z)
                    visit(std::size_t(lattice.block_of(4 * m)));
            }
        };
        char all = 0;
        near([&](std::size_t m) { all = char(all | labels[m]); });
        if (all != 3) continue;
        any = true;
        near([&](std::size_t m) { split[m] = 1; });
    }
    return any;
}

// The node's sum over the tiles of the up to eight blocks whose particles reach it.
template <class R>
Node<R> CpuSolver<R>::summed(const Sums& tiles, Int3 n) const
{
    const Int3 b = {n.x >> 2, n.y >> 2, n.z >> 2}, l = {n.x & 3, n.y & 3, n.z & 3};
    Node<R> sum{};
    for (int z = 0; z <= (l.z < 2); ++z)
        for (int y = 0; y <= (l.y < 2); ++y)
            for (int x = 0; x <= (l.x < 2); ++x) {
                const Int3 from = b - Int3{x, y, z};
                if (from.x < 0 || from.y < 0 || from.z < 0) continue;
                const int slot = bins.slot[std::size_t(lattice.block_of(4 * from))];
                if (slot < 0) continue;
                const Node<R>& share = tiles[std::size_t(slot) * tile_nodes +
                                             std::size_t(tile_index(l + 4 * Int3{x, y, z}))];
                sum = node(four(sum) + four(share));
            }
    return sum;
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
            grid[0][std::size_t(b) * block_nodes + std::size_t(l)] = update(
                summed(sums[0], n), n, lattice, walls, gravity, dt, clipped, hands);
            c.clipped += clipped;
        }
    });
}

// A block near a cut: each label has its own velocity, and the two do not pass through each other.
template <class R>
void CpuSolver<R>::split_update(int b, R dt, Counts& c)
{
    const Colliders<R> colliders = posed.colliders();
    const Mask& mask = posed.masks[std::size_t(b)];
    const Int3 block = lattice.block_at(b);
    for (int l = 0; l < block_nodes; ++l) {
        const Int3 n = 4 * block + Int3{l % 4, l / 4 % 4, l / 16};
        Node<R> sum[3], v[3];
        for (int f = 0; f < 3; ++f) {
            const auto tools = [&](Vec3<R> x, Vec3<R> u) {
                if (!setup.grid_contact) return u;
                u = held(colliders, mask, x, u);
                return f ? sliced(colliders, mask, x, u, lattice.dx, std::uint32_t(f)) : u;
            };
            sum[f] = summed(sums[f], n);
            bool clipped;
            v[f] = update(sum[f], n, lattice, walls, gravity, dt, clipped, tools);
            c.clipped += clipped;
        }
        if (sum[above].m < sum[0].m && sum[below].m < sum[0].m) {
            const auto slope = [&](Int3 axis) {
                const auto excess = [&](Int3 m) {
                    if (m.x < 0 || m.y < 0 || m.z < 0 || m.x >= lattice.size.x ||
                        m.y >= lattice.size.y || m.z >= lattice.size.z)
                        return R(0);
                    if (!split[std::size_t(lattice.block_of(m))]) return R(0);
                    return summed(sums[below], m).m - summed(sums[above], m).m;
                };
                return excess(n + axis) - excess(n - axis);
            };
            const Vec3<R> g = {slope({1, 0, 0}), slope({0, 1, 0}), slope({0, 0, 1})};
            const R size = length(g);
            if (size > 0) {
                const Vec3<R> out = (1 / size) * g;  // out of what lies above
                v[above].p = kept_apart(v[above].p, v[0].p, out, R(0.3));
                v[below].p = kept_apart(v[below].p, v[0].p, -out, R(0.3));
            }
        }
        for (int f = 0; f < 3; ++f)
            grid[f][std::size_t(b) * block_nodes + std::size_t(l)] = v[f];
    }
}

// The nodes that a block's particles can reach.
template <class R>
void CpuSolver<R>::load(const Sums& from, Int3 corner, Node<R>* tile) const
{
    for (int t = 0; t < tile_nodes; ++t) {
        const Int3 n = corner + Int3{t % tile_edge, t / tile_edge % tile_edge,
                                     t / (tile_edge * tile_edge)};
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

// At the end of a frame: a stroke that begins forgets old labels in its way, one that has ended
// leaves whole pieces.
template <class R>
void CpuSolver<R>::settle_cuts(bool covered)
{
    if (covered && !was_covered) {
        const Colliders<R> colliders = posed.colliders();
        std::vector<char> touched(q.size(), 0);
        for (std::size_t i = 0; i < q.size(); ++i)
            for_each_blade(colliders, posed.mask_at(lattice, q[i].x), q[i].x, lattice.dx,
                           [&](const Seen<R>&, const Tool<R>&) { touched[i] = 1; });
        forget(q, lattice, touched);
    }
    if (!covered && was_covered) relabel(q, lattice);
    was_covered = covered;
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

}  // namespace

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
                    c = c + double(f.weight[n]) *
                                (j.p + rotate(j.q, knead::cast<double>(f.offset[n])));
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
