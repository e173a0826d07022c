// Particles to the grid: how shares of particles of one cell become one sum before they go to
// memory. Each kernel is a whole scatter, from the particles' rows on, with the formulas of
// cuda/mpm/p2g.h.
#include "profiling/micro/merge.cuh"

namespace knead::micro {
namespace {

using gpu::Views;

constexpr int warps = threads / 32;
constexpr unsigned everyone = 0xffffffffu;

struct Loaded {
    Particle<float> q;
    Material<float> m;
    Stencil<float> s;
    int cell;  // index of the stencil's base, -1 where there is no particle
};
__device__ Loaded loaded(const Views& d)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    const gpu::ParticleView& particles = d.particles[d.clock->side];
    const bool valid = i < particles.count;
    const Particle<float> q = particles.load(valid ? i : particles.count - 1);
    Material<float> m = d.materials[q.object];
    m.elasticity = Elasticity::neo_hookean, m.plasticity = Plasticity::none;
    const Stencil<float> s = stencil(q.x, d.lattice.dx);
    return {q, m, s, valid ? d.lattice.index(s.base) : -1};
}

__device__ void add_share(const Views& d, int parity, Int3 at, float4 n)
{
    add(d.grid.nodes[parity] + d.lattice.index(at), n);
}

__global__ void __launch_bounds__(threads)
    unmerged_kernel(const __grid_constant__ Views d, int parity, float dt)
{
    const Loaded a = loaded(d);
    if (a.cell < 0) return;
    scatter(a.q, a.m, a.s, d.lattice.dx, dt, [&](Int3 step, const Node<float>& n) {
        add_share(d, parity, a.s.base + step, {n.p.x, n.p.y, n.p.z, n.m});
    });
}

// Lanes side by side of one cell, at most `max_lanes`, add up by shuffles: log2 of that rounds for
// each of 108 numbers.
template <int max_lanes>
__global__ void __launch_bounds__(threads)
    shuffled_kernel(const __grid_constant__ Views d, int parity, float dt)
{
    const Loaded a = loaded(d);
    const int lane = int(threadIdx.x & 31);
    const int before = __shfl_up_sync(everyone, a.cell, 1);
    const bool first = lane % max_lanes == 0 || before != a.cell;
    const unsigned later = __ballot_sync(everyone, first) & ~((2u << lane) - 1);
    const int end = later ? __ffs(int(later)) - 1 : 32;
    scatter(a.q, a.m, a.s, d.lattice.dx, dt, [&](Int3 step, const Node<float>& n) {
        float4 sum{n.p.x, n.p.y, n.p.z, n.m};
        UNROLL
        for (int k = 1; k < max_lanes; k *= 2) {
            const float4 b{
                __shfl_down_sync(everyone, sum.x, k), __shfl_down_sync(everyone, sum.y, k),
                __shfl_down_sync(everyone, sum.z, k), __shfl_down_sync(everyone, sum.w, k)};
            if (lane + k < end) sum = {sum.x + b.x, sum.y + b.y, sum.z + b.z, sum.w + b.w};
        }
        if (first && a.cell >= 0) add_share(d, parity, a.s.base + step, sum);
    });
}

// What a warp's lanes wrote down: columns of nodes, and what tells the nodes of a column apart.
struct Written {
    float4 rows[32][9], slopes[32], weights[32];
    int cells[33];   // first lane of each cell; one more than there are
    Int3 bases[32];  // by cell
};

__device__ void write_slot(const Loaded& a, Written& w, int slot, float dx, float dt)
{
    const Momentum<float> p =
        momentum(a.q, kirchhoff_stress(a.q, a.m), a.m, 1 / a.m.mass, a.s, dx, dt);
    const Vec3<float> slope = p.along_z;
    UNROLL
    for (int r = 0; r < 9; ++r) {
        const Node<float> n = node(column_of(p, a.s, r % 3, r / 3));
        w.rows[slot][r] = {n.p.x, n.p.y, n.p.z, n.m};
    }
    w.slopes[slot] = {slope.x, slope.y, slope.z, 0};
    w.weights[slot] = {a.s.w[0].z, a.s.w[1].z, a.s.w[2].z, 0};
}

// Cells as lanes side by side have them; how many.
__device__ int write_down(const Loaded& a, Written& w, float dx, float dt)
{
    const int lane = int(threadIdx.x & 31);
    write_slot(a, w, lane, dx, dt);
    const int before = __shfl_up_sync(everyone, a.cell, 1);
    const bool first = (lane == 0 || before != a.cell) && a.cell >= 0;
    const unsigned firsts = __ballot_sync(everyone, first);
    const int here = __popc(firsts & ((1u << lane) - 1));
    if (first) w.cells[here] = lane, w.bases[here] = a.s.base;
    const int cells = __popc(firsts), valid = __popc(__ballot_sync(everyone, a.cell >= 0));
    if (lane == 0) w.cells[cells] = valid;
    __syncwarp();
    return cells;
}

__device__ float4 plus(float4 sum, float4 row, float4 slope, float i, float weight)
{
    const Node<float> n = node(along(four(Vec3<float>{row.x, row.y, row.z}, row.w), weight,
                                     i * Vec3<float>{slope.x, slope.y, slope.z}));
    return {sum.x + n.p.x, sum.y + n.p.y, sum.z + n.p.z, sum.w + n.m};
}

// As write_down, for particles in any order: lanes of one cell are put side by side first.
__device__ int write_down_by_cell(const Loaded& a, Written& w, float dx, float dt)
{
    const int lane = int(threadIdx.x & 31);
    const unsigned same = __match_any_sync(everyone, a.cell);
    const bool first = lane == __ffs(int(same)) - 1 && a.cell >= 0;
    // A cell's first slot is how many lanes the cells before it have.
    const unsigned firsts = __ballot_sync(everyone, first);
    int until = first ? __popc(same) : 0;
    UNROLL
    for (int k = 1; k < 32; k *= 2) {
        const int other = __shfl_up_sync(everyone, until, unsigned(k));
        if (lane >= k) until += other;
    }
    const int start = __shfl_sync(everyone, first ? until - __popc(same) : 0, __ffs(int(same)) - 1);
    const int slot = start + __popc(same & ((1u << lane) - 1));
    const int valid = __shfl_sync(everyone, until, 31);
    if (a.cell >= 0) write_slot(a, w, slot, dx, dt);
    const int here = __popc(firsts & ((1u << lane) - 1));
    if (first) w.cells[here] = start, w.bases[here] = a.s.base;
    const int cells = __popc(firsts);
    if (lane == 0) w.cells[cells] = valid;
    __syncwarp();
    return cells;
}

// One cell after the other; a lane has a node.
template <bool by_cell>
__global__ void __launch_bounds__(threads)
    node_walk_kernel(const __grid_constant__ Views d, int parity, float dt)
{
    __shared__ Written space[warps];
    Written& w = space[threadIdx.x >> 5];
    const Loaded a = loaded(d);
    const int cells =
        by_cell ? write_down_by_cell(a, w, d.lattice.dx, dt) : write_down(a, w, d.lattice.dx, dt);
    const int lane = int(threadIdx.x & 31), node = min(lane, 26), along_z = node % 3;
    for (int c = 0; c < cells; ++c) {
        float4 sum{0, 0, 0, 0};
        for (int k = w.cells[c]; k < w.cells[c + 1]; ++k)
            sum = plus(sum, w.rows[k][node / 3], w.slopes[k], float(along_z),
                       reinterpret_cast<const float*>(w.weights + k)[along_z]);
        if (lane < 27)
            add_share(d, parity, w.bases[c] + Int3{node / 3 % 3, node / 9, along_z}, sum);
    }
}

// Three cells at a time; a lane has a row of three nodes.
__global__ void __launch_bounds__(threads)
    row_walk_kernel(const __grid_constant__ Views d, int parity, float dt)
{
    __shared__ Written space[warps];
    Written& w = space[threadIdx.x >> 5];
    const int cells = write_down(loaded(d), w, d.lattice.dx, dt);
    const int lane = int(threadIdx.x & 31), row = lane % 9;
    for (int c = lane / 9; c < cells && lane < 27; c += 3) {
        float4 sums[3] = {};
        for (int k = w.cells[c]; k < w.cells[c + 1]; ++k) {
            const float4 r = w.rows[k][row], slope = w.slopes[k], weight = w.weights[k];
            sums[0] = plus(sums[0], r, slope, 0, weight.x);
            sums[1] = plus(sums[1], r, slope, 1, weight.y);
            sums[2] = plus(sums[2], r, slope, 2, weight.z);
        }
        UNROLL
        for (int i = 0; i < 3; ++i)
            add_share(d, parity, w.bases[c] + Int3{row % 3, row / 3, i}, sums[i]);
    }
}

}  // namespace

void Scatters::time(const std::string& what, const std::function<void()>& run, double adds)
{
    Row row{question, what + of, "particle"};
    row.count = clay.count();
    row.max = adds > 0 ? bench.limits.adds / adds : bench.by_copy(bytes_of_particle);
    row.limit = adds > 0 ? "atomics" : "copy";
    bench.add(
        row, [&] { clay.clear(); }, run, [&] { return right(); });
}

// Mass is all there, and nodes are as the first form left them.
bool Scatters::right()
{
    const std::vector<float4> nodes = clay.nodes();
    double mass = 0, max_mass = 0, max_momentum = 0;
    for (const float4& n : nodes) {
        mass += double(n.w);
        max_mass = std::max(max_mass, double(n.w));
        max_momentum = std::max(
            {max_momentum, std::fabs(double(n.x)), std::fabs(double(n.y)), std::fabs(double(n.z))});
    }
    if (first.empty()) first = nodes;
    double off = 0;
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const float4 &a = nodes[i], &b = first[i];
        const auto apart = [&](float p, float q, double scale) {
            off = std::max(off, std::fabs(double(p) - double(q)) / scale);
        };
        apart(a.x, b.x, max_momentum), apart(a.y, b.y, max_momentum);
        apart(a.z, b.z, max_momentum), apart(a.w, b.w, max_mass);
    }
    return std::fabs(mass / clay.mass() - 1) < 1e-5 && off < 1e-5;
}

void Scatters::unmerged() { run("an atomic a node", unmerged_kernel, 27); }

void Scatters::walked()
{
    run("written down, a lane walks for a node", node_walk_kernel<false>, 0);
    run("the same, cells put together first", node_walk_kernel<true>, 0);
}

void Scatters::shipped()
{
    time(
        "as shipped: p2g, blocks listed, too",
        [&] { gpu::p2g(clay.views(), clay.features(), 0, false, bench.stream); }, 0);
}

void Scatters::all()
{
    unmerged();
    run("shuffles, 2 lanes", shuffled_kernel<2>, 0);
    run("shuffles, 4 lanes", shuffled_kernel<4>, 0);
    run("shuffles, 8 lanes", shuffled_kernel<8>, 0);
    walked();
    run("written down, a lane walks for a row, 3 cells", row_walk_kernel, 0);
    shipped();
}

void Scatters::run(const char* what, void (*kernel)(Views, int, float), double adds)
{
    must_not_spill(what, kernel);
    time(
        what,
        [&, kernel] {
            launch("merge", kernel, blocks_for(clay.count(), threads), threads, bench.stream,
                   clay.views(), clay.parity(), clay.dt());
        },
        adds);
}

void measure_merge(Bench& bench)
{
    for (int nodes : {64, 128}) {
        Clay clay(nodes, Order::by_cell, bench.stream);
        Scatters{bench, clay, "merge", ", " + std::to_string(nodes) + "^3"}.all();
    }
}

// What disorder costs: whether sorting has to be kept up from substep to substep.
void measure_order(Bench& bench)
{
    const auto time = [&](Order order, const char* name) {
        Clay clay(128, order, bench.stream);
        Scatters scatters{bench, clay, "order", std::string(", ") + name};
        scatters.unmerged();
        scatters.walked();
        scatters.shipped();
    };
    time(Order::by_cell, "by cell");
    time(Order::drifted, "drifted by up to half a cell");
    time(Order::by_block, "by block of 64 cells");
    time(Order::none, "in no order");
}

}  // namespace knead::micro
