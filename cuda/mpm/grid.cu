// Grid update: one thread block per listed block of nodes, as many as there are, however many the
// launch brings. The grid of the substep before is cleared on the way, and a block of its own looks
// after the clock.
#include "cuda/contact/contact.cuh"
#include "cuda/contact/cut.h"
#include "cuda/device/launch.cuh"
#include "cuda/mpm/grid.h"
#include "cuda/mpm/sleep.cuh"
#include "cuda/mpm/stages.cuh"
#include "cuda/mpm/walls.cuh"

namespace knead::gpu {
namespace {

// Threads and thread blocks per multiprocessor; how many blocks of nodes a thread block has in
// hand. With tools it is two, one for each half of it; but where a tool may be near, all its
// threads look after one block, so that a warp shares the closest points of fewer nodes.
template <bool tools>
constexpr int threads = tools ? 2 * block_nodes : block_nodes;
template <bool tools>
constexpr int resident = tools ? 4 : 12;
constexpr int resident_cut = 8;
template <bool tools>
constexpr int blocks_per_cta = tools ? 2 : 1;
constexpr int shared_nodes = 32 * block_nodes / threads<true>;  // of a warp, near tools

template <bool fixed_point>
__device__ void clear(const GridUpdateView& d, int parity, int i)
{
    if constexpr (fixed_point) {
        longlong2* at = reinterpret_cast<longlong2*>(d.sums[parity] + 4 * std::size_t(i));
        at[0] = at[1] = longlong2{0, 0};
    } else {
        d.nodes[parity][i] = {0, 0, 0, 0};
    }
}

// Of a ring of three, the place of substep n.
template <class T>
__device__ T in_ring(int n, const T (&ring)[3])
{
    const int k = n % 3;
    return k == 0 ? ring[0] : k == 1 ? ring[1] : ring[2];
}

// Counts the substep, and chooses the one after it from the speeds that the one before it left.
__device__ void look_ahead(const GridUpdateView& d)
{
    Clock& c = *d.clock;
    Counters& all = c.counters;
    const int n = c.done, before = (n + 1) & 1;
    const Step step = c.step(n);
    const Extremes clay = c.extremes(n);
    Step next = step_after(step, d.limits, clay, c.tool_step, c.duration);
    if ((c.crowded[before] || c.halt) && step.dt > 0 && next.dt > 0)
        c.mode = c.crowded[before] ? Mode::stopped : Mode::cut, c.resume = next, next.dt = 0;
    c.crowded[before] = false;
    c.begun = n;
    c.set_peak(n, {});
    c.woken[n & 1] = 0;
    c.active[(n + 1) % 3] = c.active[n % 3];
    c.drift += clay.speed * step.dt;
    c.step(n + 1) = next;
    c.dt[0] = float(step.dt), c.dt[1] = float(next.dt);
    if (!(step.dt > 0)) return;
    if (c.lag.due()) c.lag = {};  // the substep before has moved them
    c.lag.add(step.dt);
    all.dt_min = all.substeps ? min(all.dt_min, step.dt) : step.dt;
    all.dt_max = max(all.dt_max, step.dt);
    ++all.substeps;
    ++all.limits[int(step.limit)];
    all.active_blocks = c.active[n % 3];
}

// The substep under way, and what a thread block begins with. All loads that may be needed are
// issued at once, not one after the other; what the clock's own block writes meanwhile is not used.
template <int blocks_per_cta>
struct Start {
    int n;
    float dt;                                         // [s]
    int count, before;                                // blocks listed of this grid and of the other
    int blocks[blocks_per_cta], old[blocks_per_cta];  // the first of each
};

template <int blocks_per_cta>
__device__ Start<blocks_per_cta> started(const GridUpdateView& d)
{
    const Clock& c = *d.clock;
    int lists[3][blocks_per_cta];
    UNROLL
    for (int k = 0; k < blocks_per_cta; ++k) {
        const int at = int(blockIdx.x) - 1 + k * (int(gridDim.x) - 1);
        const int first = min(max(at, 0), d.lattice.block_count() - 1);
        UNROLL
        for (int l = 0; l < 3; ++l) lists[l][k] = d.list[l][first];
    }
    const int n = c.done, active[] = {c.active[0], c.active[1], c.active[2]};
    const double dt[] = {c.steps[0].dt, c.steps[1].dt, c.steps[2].dt};
    Start<blocks_per_cta> s{
        n, float(in_ring(n, dt)), in_ring(n, active), in_ring(n + 2, active), {}, {}};
    UNROLL
    for (int k = 0; k < blocks_per_cta; ++k) {
        s.blocks[k] = in_ring(n, {lists[0][k], lists[1][k], lists[2][k]});
        s.old[k] = in_ring(n + 2, {lists[0][k], lists[1][k], lists[2][k]});
    }
    return s;
}

// The clock's own block: one thread looks ahead, other warps at the blocks that were listed since
// the substep before. Those of a frame's first are looked at by p2g.
__device__ void look_around(const GridUpdateView& d)
{
    if (threadIdx.x == 0) look_ahead(d);
    if (threadIdx.x < 32) return;
    const auto start = started<1>(d);
    if (!(start.dt > 0)) return;
    for (int k = start.before + int(threadIdx.x) - 32; k < start.count; k += int(blockDim.x) - 32)
        if (d.rim[d.list[start.n % 3][k]]) d.clock->crowded[start.n & 1] = true;
}

// Calls update(blocks) for all listed blocks of nodes, so many at a time, after clearing as many of
// the other grid; -1 stands for none. They are listed for the next substep, too.
template <bool fixed_point, int blocks_per_cta, class Update>
__device__ void for_each_block(const GridUpdateView& d, Start<blocks_per_cta> s, Update&& update)
{
    const int *const now = d.list[s.n % 3], *const last = d.list[(s.n + 2) % 3];
    int* const next = d.list[(s.n + 1) % 3];
    const int parity = s.n & 1, stride = int(gridDim.x) - 1, fields = d.fields;
    for (int at = int(blockIdx.x) - 1; at < s.count || at < s.before;
         at += blocks_per_cta * stride) {
        int here[blocks_per_cta];
        UNROLL
        for (int k = 0; k < blocks_per_cta; ++k) {
            const int own = at + k * stride, then = own + blocks_per_cta * stride;
            here[k] = own < s.count ? s.blocks[k] : -1;
            const int old = own < s.before ? s.old[k] : -1;
            if (threadIdx.x == 0 && here[k] >= 0)
                next[own] = here[k], d.marks[here[k]] = listed_for(s.n + 1, false);
            if (then < s.count) s.blocks[k] = now[then];
            if (then < s.before) s.old[k] = last[then];
            if (old < 0) continue;
            for (int i = int(threadIdx.x); i < fields * block_nodes; i += int(blockDim.x))
                clear<fixed_point>(
                    d, parity ^ 1,
                    i / block_nodes * d.lattice.node_count() + old * block_nodes + i % block_nodes);
        }
        update(here);
    }
}

using SharedSpace = ContactSpace<shared_nodes>;

// apply_tools() by all lanes of a warp, for those that are `in`; of tools without blades.
__device__ Vec3<float> apply_tools_by_warp(SharedSpace& space, const Colliders<float>& c,
                                           const Mask& mask, bool in, Vec3<float> x, Vec3<float> v)
{
    WarpContact<shared_nodes> contact(space, c);
    const int near = contact.look(mask, in, x, [&c](int i) { return c.primitives[i].tool; });
    for (int from = 0, to; from < near; from = to) {
        to = contact.run_end(from, near);
        const Tool<float>& tool = c.tools[contact.label(from)];
        const Contact<float> hit = contact.deepest(from, to, in, x);
        if (hit.phi < 0) v = apply_contact(v, hit.n, hit.v, tool.mode, tool.friction);
    }
    return v;
}

// The node of index i, by lanes that `own` one; tools(in, x, v) by all lanes of a warp.
template <bool fixed_point, class Tools>
__device__ void update_node(const GridUpdateView& d, int parity, float dt, int i, bool own,
                            Tools&& tools)
{
    const Int3 at = d.lattice.node_at(i);
    const Node<float> sum = own ? sum_of<fixed_point>(d, parity, i) : Node<float>{};
    const bool clay = sum.m > 0;
    Vec3<float> v{};
    if (clay) v = apply_gravity(sum, d.gravity, dt);
    const Vec3<float> free = v;
    v = tools(clay, d.lattice.position(at), v);
    if (!own) return;
    if (clay && !clear_of(at, d.walls))
        return update_at_wall<fixed_point>(d, parity, dt, at, sum.m, v, differ(v, free));
    bool clipped = false;
    if (clay) v = limit_speed(v, d.lattice, dt, clipped);
    d.nodes[parity][i] = {v.x, v.y, v.z, clay ? sum.m : 0};
    if (clipped) count_slowed(d, sum.m);
}

// The nodes of block b, which tools may touch, by all warps of a thread block.
template <bool fixed_point>
__device__ void update_together(const GridUpdateView& d, SharedSpace& space, int n, float dt, int b)
{
    const int lane = int(threadIdx.x & 31), node = lane % shared_nodes;
    const int i = b * block_nodes + int(threadIdx.x >> 5) * shared_nodes + node;
    const auto tools = [&](bool clay, Vec3<float> x, Vec3<float> v) {
        return apply_tools_by_warp(space, d.contact.colliders(n), d.masks[b],
                                   __shfl_sync(0xffffffffu, clay, node), x, v);
    };
    update_node<fixed_point>(d, n & 1, dt, i, lane == node, tools);
}

template <class Case>
__global__ void __launch_bounds__(threads<Case::features.tools>, resident<Case::features.tools>)
    grid_kernel(const __grid_constant__ GridUpdateView d)
{
    constexpr bool tools = Case::features.tools, fixed_point = Case::features.fixed_point;
    __shared__ SharedSpace spaces[tools ? block_nodes / shared_nodes : 1];
    wait_for_upstream();
    if (blockIdx.x == 0) return look_around(d);
    const auto start = started<blocks_per_cta<tools>>(d);
    const int n = start.n, parity = n & 1;
    const float dt = start.dt;
    if (!(dt > 0)) return;
    if (d.rest.mode == RestMode::sleep) guard_neighbours(d, n);
    for_each_block<fixed_point>(d, start, [&](const int(&blocks)[blocks_per_cta<tools>]) {
        const auto near = [&](int b) { return tools && b >= 0 && !empty(loaded(d.masks[b])); };
        const int half = int(threadIdx.x) / block_nodes;
        const int own = half ? blocks[blocks_per_cta<tools> - 1] : blocks[0];
        if (own >= 0 && !near(own))
            update_node<fixed_point>(d, parity, dt,
                                     own * block_nodes + int(threadIdx.x) % block_nodes, true,
                                     [](bool, Vec3<float>, Vec3<float> v) { return v; });
        for (int k = 0; tools && k < 2; ++k) {
            const int b = k ? blocks[blocks_per_cta<tools> - 1] : blocks[0];
            if (near(b)) update_together<fixed_point>(d, spaces[threadIdx.x >> 5], n, dt, b);
        }
    });
}

// Which way lies what is below, at node n: along the slope of its mass less that of what is above.
template <bool fixed_point>
__device__ Vec3<float> slope(const GridUpdateView& d, int parity, Int3 n)
{
    const int count = d.lattice.node_count();
    return knead::slope(d.lattice, n, [&](Int3 m) {
        const int i = d.lattice.index(m);
        return sum_of<fixed_point>(d, parity, below * count + i).m -
               sum_of<fixed_point>(d, parity, above * count + i).m;
    });
}

template <bool fixed_point>
__device__ void keep_apart(const GridUpdateView& d, int parity, Int3 n)
{
    const int nodes = d.lattice.node_count(), i = d.lattice.index(n);
    Node<float> v[3];
    float mass[3];
    UNROLL
    for (int f = 0; f < 3; ++f) v[f] = node_at(d, parity, f * nodes + i), mass[f] = v[f].m;
    divide(v, mass, [&] { return slope<fixed_point>(d, parity, n); });
    UNROLL
    for (int f = 1; f < 3; ++f) node_at(d, parity, f * nodes + i) = v[f];
}

// Where blades are: each label has its own velocity, and the two do not pass through each other.
// Neighbours read masses here, which the update leaves as they are.
template <class Case>
__global__ void __launch_bounds__(block_nodes, resident_cut)
    cut_grid_kernel(const __grid_constant__ GridUpdateView d)
{
    constexpr bool fixed_point = Case::features.fixed_point;
    wait_for_upstream();
    if (blockIdx.x == 0) return look_around(d);
    const auto start = started<1>(d);
    const int n = start.n, parity = n & 1, nodes = d.lattice.node_count();
    const float dt = start.dt, dx = d.lattice.dx;
    if (!(dt > 0)) return;
    if (d.rest.mode == RestMode::sleep) guard_neighbours(d, n);
    const Colliders<float> colliders = d.contact.colliders(n);
    for_each_block<fixed_point>(d, start, [&](const int(&blocks)[1]) {
        const int b = blocks[0];
        if (b < 0) return;
        const int i = b * block_nodes + int(threadIdx.x);
        const Int3 at = d.lattice.node_at(i);
        const Mask& mask = d.masks[b];
        const Together how = together<fixed_point>(d, parity, at);
        const bool clay = sum_of<fixed_point>(d, parity, i).m > 0;
        if (clay && how.elsewhere) return;
        const int count = clay ? image_count(how.way) : 1;
        for (int f = 0; f < 3; ++f) {
            const Node<float> sum = sum_of<fixed_point>(d, parity, f * nodes + i);
            const auto tools = [&](Vec3<float> x, Vec3<float> u) {
                if (!d.grid_contact) return u;
                u = apply_tools(colliders, mask, x, u);
                return f ? sliced(colliders, mask, x, u, dx, unsigned(f)) : u;
            };
            if (count > 1 && sum.m > 0) {
                const Vec3<float> free = apply_gravity(sum, d.gravity, dt);
                const Vec3<float> v = tools(d.lattice.position(at), free);
                update_with_images<fixed_point>(d, parity, dt, at, how.way, v, differ(v, free),
                                                f * nodes);
                continue;
            }
            bool clipped;
            node_at(d, parity, f * nodes + i) =
                update(sum, at, d.lattice, d.walls, d.gravity, dt, clipped, tools);
            if (clipped) count_slowed(d, sum.m);
        }
        for (int k = 0; k < count; ++k) keep_apart<fixed_point>(d, parity, image(at, how.way, k));
    });
}

constexpr Features relevant(Features f)
{
    return {.tools = f.tools, .fixed_point = f.fixed_point, .blades = f.blades};
}

struct Launch {
    void (*kernel)(GridUpdateView);
    int threads, resident;
};
constexpr auto launch_for = []<class Case>(Case) -> Launch {
    constexpr Features f = Case::features;
    if constexpr (f.blades)
        return {cut_grid_kernel<Case>, block_nodes, resident_cut};
    else
        return {grid_kernel<Case>, threads<f.tools>, resident<f.tools>};
};

}  // namespace

void grid(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream)
{
    Features used = features;
    used.tools = used.tools && views.tools.grid_contact;
    const Launch by = dispatch<relevant>(used, launch_for);
    const int blocks = 1 + min(views.lattice.block_count(), by.resident * multiprocessors - 1);
    launch_pdl("grid", by.kernel, blocks, by.threads, stream, grid_view(views));
}

}  // namespace knead::gpu
