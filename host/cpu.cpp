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
    long yielded = 0, projected = 0, clipped = 0, confined = 0, repaired = 0;
    double depth = 0, speed_squared = 0;
    double seconds[stage_count] = {};
    void add(const Counts& c)
    {
        yielded += c.yielded, projected += c.projected, clipped += c.clipped;
        confined += c.confined, repaired += c.repaired;
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
    void pose(const Motion& motion, double s0, double s1, double dt);
    void mask_blocks(const Motion& motion);
    void p2g(R dt);
    void grid_update(R dt);
    void g2p(R dt);
    Node<R> summed(Int3 node_block, int local) const;
    void step_particles(int slot, R dt, const Node<R>* tile, Counts& counts);
    template <class Body>
    void for_each(int count, StageName stage, Body&& body);

    Setup setup;
    Lattice<R> lattice;
    Walls<R> walls;
    Vec3<R> gravity;
    int threads;
    std::vector<Material<R>> materials;
    std::vector<Binding<R>> bindings;
    std::vector<Tool<R>> tools;
    std::vector<Particle<R>> q;   // in the order of the last sort by block
    std::vector<int> ids;         // original index of q[i]
    Bins bins;
    std::vector<Node<R>> sums;    // tile_nodes per occupied block
    std::vector<Node<R>> grid;    // velocities after the grid update
    std::vector<Sphere<R>> spheres;
    std::vector<Shape<R>> shapes;
    std::vector<Mask> masks;      // per lattice block
    std::vector<Int3> masked;     // blocks whose mask is not empty
    Colliders<R> colliders;
    std::vector<Counts> counts;   // per thread
    std::vector<StageTime> times;
};

template <class R>
CpuSolver<R>::CpuSolver(const Setup& given)
    : setup(given),
      lattice{given.lattice.size, R(given.lattice.dx)},
      walls{given.walls.margin, given.walls.touch, R(given.walls.friction)},
      gravity(knead::cast<R>(given.gravity)),
      threads(given.threads > 0 ? given.threads : omp_get_max_threads())
{
    for (const Material<double>& m : setup.materials) materials.push_back(cast<R>(m));
    for (const Particle<double>& p : setup.particles) q.push_back(cast<R>(p));
    for (const Binding<float>& b : setup.rig.spheres) {
        Binding<R> c{};
        for (int k = 0; k < 4; ++k)
            c.joint[k] = b.joint[k], c.weight[k] = R(b.weight[k]),
            c.offset[k] = knead::cast<R>(b.offset[k]);
        c.radius = R(b.radius);
        bindings.push_back(c);
    }
    for (const Tool<double>& t : setup.tools)
        tools.push_back({t.touch, R(t.friction), t.blade, t.active});
    setup.particles.clear();
    ids.resize(q.size());
    std::iota(ids.begin(), ids.end(), 0);
    grid.resize(std::size_t(lattice.node_count()));
    masks.resize(std::size_t(lattice.block_count()));
    spheres.resize(bindings.size());
    shapes.resize(setup.rig.primitives.size());
    colliders = {{spheres.data(), int(spheres.size())},
                 {setup.rig.primitives.data(), int(setup.rig.primitives.size())},
                 {shapes.data(), int(shapes.size())},
                 {tools.data(), int(tools.size())}};
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
    const double tool_dt = bindings.empty() ? 1e30 : tool_step(setup, motion, duration);
    for (std::size_t t = 0; t < tools.size(); ++t)
        tools[t].active = t >= motion.active.size() || motion.active[t];

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
        if (!bindings.empty()) {
            pose(motion, from, done / duration, step.dt);
            mask_blocks(motion);
        }
        times[stage_pose].seconds += omp_get_wtime() - start;
        start = omp_get_wtime();
        bins.fill(q, lattice.block_count(), key, lattice.blocks(), threads);
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

// Tools at the end of the substep that covers the shares [s0, s1] of the frame.
template <class R>
void CpuSolver<R>::pose(const Motion& motion, double s0, double s1, double dt)
{
    const auto at = [&](double s) {
        return [&motion, s](int j) {
            const auto n = std::size_t(j);
            const Joint<double> b = between(motion.from[n], motion.to[n], s);
            return Joint<R>{knead::cast<R>(b.q), knead::cast<R>(b.p)};
        };
    };
    for (std::size_t i = 0; i < bindings.size(); ++i)
        spheres[i] = posed(bindings[i], at(s0), at(s1), R(dt));
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const Primitive& p = setup.rig.primitives[i];
        shapes[i] = shape(p.count, spheres[std::size_t(p.sphere[0])],
                          spheres[std::size_t(p.sphere[1])], spheres[std::size_t(p.sphere[2])]);
    }
}

// Candidates of every block near a tool; blocks far away keep an empty mask.
template <class R>
void CpuSolver<R>::mask_blocks(const Motion&)
{
    for (Int3 b : masked) masks[std::size_t(lattice.block_of(4 * b))] = {};
    masked.clear();
    const R edge = block_edge * lattice.dx;
    const Int3 size = lattice.blocks();
    for (std::size_t i = 0; i < shapes.size(); ++i) {
        const Tool<R>& tool = tools[std::size_t(setup.rig.primitives[i].tool)];
        if (!tool.active) continue;
        const R band = (tool.blade ? blade_reach : R(0.5)) * lattice.dx;
        const auto low = [&](R x, int n) { return std::clamp(int((x - band) / edge) - 1, 0, n - 1); };
        const auto high = [&](R x, int n) { return std::clamp(int((x + band) / edge), 0, n - 1); };
        const Shape<R>& s = shapes[i];
        for (int z = low(s.low.z, size.z); z <= high(s.high.z, size.z); ++z)
            for (int y = low(s.low.y, size.y); y <= high(s.high.y, size.y); ++y)
                for (int x = low(s.low.x, size.x); x <= high(s.high.x, size.x); ++x) {
                    const Vec3<R> middle = {edge * (R(x) + R(0.5)), edge * (R(y) + R(0.5)),
                                            edge * (R(z) + R(0.5))};
                    if (!reaches(s, middle, edge, band)) continue;
                    Mask& m = masks[std::size_t(lattice.block_of({4 * x, 4 * y, 4 * z}))];
                    if (std::all_of(m.bits, m.bits + mask_words, [](auto b) { return b == 0; }))
                        masked.push_back({x, y, z});
                    m.bits[i / 32] |= 1u << (i % 32);
                }
    }
}

// Each occupied block sums its particles into a tile of its own.
template <class R>
void CpuSolver<R>::p2g(R dt)
{
    sums.resize(bins.occupied.size() * tile_nodes);
    for_each(int(bins.occupied.size()), stage_p2g, [&](int slot, Counts&) {
        Node<R>* tile = &sums[std::size_t(slot) * tile_nodes];
        std::memset(static_cast<void*>(tile), 0, tile_nodes * sizeof(Node<R>));
        const Int3 corner = 4 * lattice.block_at(bins.occupied[std::size_t(slot)]);
        for (int i : bins.members(slot)) {
            const Particle<R>& p = q[std::size_t(i)];
            const Stencil<R> s = stencil(p.x, lattice.dx);
            Node<R>* base = tile + tile_index(s.base - corner);
            scatter(p, materials[std::size_t(p.object)], s, lattice.dx, dt,
                    [&](Int3 step, const Node<R>& share) {
                        Node<R>& n = base[tile_index(step)];
                        n = node(four(n) + four(share));
                    });
        }
    });
}

// The node's sum over the tiles of the up to eight blocks whose particles reach it.
template <class R>
Node<R> CpuSolver<R>::summed(Int3 b, int local) const
{
    const Int3 l = {local % 4, local / 4 % 4, local / 16};
    Node<R> sum{};
    for (int z = 0; z <= (l.z < 2); ++z)
        for (int y = 0; y <= (l.y < 2); ++y)
            for (int x = 0; x <= (l.x < 2); ++x) {
                const Int3 from = b - Int3{x, y, z};
                if (from.x < 0 || from.y < 0 || from.z < 0) continue;
                const int slot = bins.slot[std::size_t(lattice.block_of(4 * from))];
                if (slot < 0) continue;
                const Node<R>& n = sums[std::size_t(slot) * tile_nodes +
                                        std::size_t(tile_index(l + 4 * Int3{x, y, z}))];
                sum = node(four(sum) + four(n));
            }
    return sum;
}

template <class R>
void CpuSolver<R>::grid_update(R dt)
{
    for_each(int(bins.touched.size()), stage_grid, [&](int t, Counts& c) {
        const int b = bins.touched[std::size_t(t)];
        const Int3 block = lattice.block_at(b);
        const Mask& mask = masks[std::size_t(b)];
        const auto hands = [&](Vec3<R> x, Vec3<R> v) {
            return setup.grid_contact ? held(colliders, mask, x, v) : v;
        };
        for (int l = 0; l < block_nodes; ++l) {
            const Int3 n = 4 * block + Int3{l % 4, l / 4 % 4, l / 16};
            bool clipped;
            grid[std::size_t(b) * block_nodes + std::size_t(l)] =
                update(summed(block, l), n, lattice, walls, gravity, dt, clipped, hands);
            c.clipped += clipped;
        }
    });
}

template <class R>
void CpuSolver<R>::g2p(R dt)
{
    for_each(int(bins.occupied.size()), stage_g2p, [&](int slot, Counts& c) {
        const Int3 corner = 4 * lattice.block_at(bins.occupied[std::size_t(slot)]);
        Node<R> tile[tile_nodes];
        for (int t = 0; t < tile_nodes; ++t) {
            const Int3 n = corner + Int3{t % tile_edge, t / tile_edge % tile_edge,
                                         t / (tile_edge * tile_edge)};
            if (n.x < lattice.size.x && n.y < lattice.size.y && n.z < lattice.size.z)
                tile[t] = grid[std::size_t(lattice.index(n))];
        }
        step_particles(slot, dt, tile, c);
    });
}

// A block's particles: gather and move, then project, then flow.
template <class R>
void CpuSolver<R>::step_particles(int slot, R dt, const Node<R>* tile, Counts& c)
{
    const Int3 corner = 4 * lattice.block_at(bins.occupied[std::size_t(slot)]);
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
        const Node<R>* base = tile + tile_index(s.base - corner);
        gather(p, s, lattice.dx, [&](Int3 step) { return four(base[tile_index(step)]); });
        p.e = strained(p.e, p.C, dt);
        p.x = p.x + dt * p.v;
    }
    lap(stage_g2p);
    for (int i : members) {
        Particle<R>& p = q[std::size_t(i)];
        if (setup.passes > 0 && !masked.empty()) {
            const Int3 cell = {int(p.x.x / lattice.dx), int(p.x.y / lattice.dx),
                               int(p.x.z / lattice.dx)};
            if (cell.x >= 0 && cell.y >= 0 && cell.z >= 0 && cell.x < lattice.size.x &&
                cell.y < lattice.size.y && cell.z < lattice.size.z) {
                const R depth = project(p, colliders, masks[std::size_t(lattice.block_of(cell))],
                                        setup.passes);
                c.projected += depth > 0;
                c.depth = std::max(c.depth, double(depth));
            }
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
    if (masked.empty()) return depths;
    for (const Particle<R>& p : q) {
        const Int3 cell = {int(p.x.x / lattice.dx), int(p.x.y / lattice.dx),
                           int(p.x.z / lattice.dx)};
        const Contact<R> hit =
            nearest(colliders, masks[std::size_t(lattice.block_of(cell))], p.x);
        if (hit.phi < 0) depths.push_back(double(-hit.phi));
    }
    return depths;
}

template <class R>
std::size_t CpuSolver<R>::memory() const
{
    return q.capacity() * (sizeof(Particle<R>) + 3 * sizeof(int)) +
           grid.capacity() * sizeof(Node<R>) + sums.capacity() * sizeof(Node<R>) +
           masks.capacity() * sizeof(Mask);
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
