// Grid update kernels. Thread blocks stride over the listed blocks of nodes and clear the grid of
// the previous substep; thread block 0 updates the clock. If tools may touch one of a thread
// block's first blocks of nodes, contact there is evaluated while the previous substep still runs
// (substep_sync.cuh).
#include "cuda/contact/cut.h"
#include "cuda/mpm/body_contact.h"
#include "cuda/mpm/grid.h"
#include "cuda/mpm/near_tools.cuh"
#include "cuda/mpm/sleep.cuh"
#include "cuda/mpm/stages.cuh"
#include "cuda/mpm/substep_sync.cuh"
#include "cuda/mpm/walls.cuh"

namespace knead::gpu {
namespace {

// Threads per thread block, thread blocks per multiprocessor, and blocks of nodes that a thread
// block updates at a time. With tools it updates two, each with half of its threads. Near a tool
// all its threads update one block: a warp then has fewer nodes, and its lanes share the search for
// their closest points.
template <bool tools>
constexpr int threads = tools ? 32 * block_nodes / shared_nodes : block_nodes;
template <bool tools>
constexpr int resident = tools ? 4 : 10;
constexpr int resident_cut = 8;
template <bool tools>
constexpr int blocks_per_cta = tools ? 2 : 1;

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

// Input of thread block 0: the current substep, and the quantities that determine the next one's
// length.
struct StepBasis {
    int n;
    Step step;
    Extremes clay;               // from the previous substep
    double tool_step, duration;  // [s]
    __device__ Step next(const StepLimits& limits) const
    {
        return step_after(step, limits, clay, tool_step, duration);
    }
};

// After the previous substep has ended. All loads are issued together.
__device__ StepBasis step_basis(const Clock& c)
{
    const int n = __ldcg(&c.done);
    uint4 peaks[peak_places];
    UNROLL
    for (int k = 0; k < peak_places; ++k)
        peaks[k] = __ldcg(reinterpret_cast<const uint4*>(c.peaks[k].of));
    double start[3], dt[3];
    int limit[3];
    UNROLL
    for (int k = 0; k < 3; ++k) {
        start[k] = __ldcg(&c.steps[k].start), dt[k] = __ldcg(&c.steps[k].dt);
        limit[k] = __ldcg(reinterpret_cast<const int*>(&c.steps[k].limit));
    }
    const double tool_step = __ldcg(&c.tool_step), duration = __ldcg(&c.duration);
    const Step now{in_ring(n, start), in_ring(n, dt), Limit(in_ring(n, limit))};
    Peak left{};
    UNROLL
    for (const uint4& p : peaks) left = largest(left, n & 1 ? Peak{p.x, p.y} : Peak{p.z, p.w});
    return {n, now, extremes_of(left), tool_step, duration};
}

// Counts the substep, and chooses the next one from the speeds of the previous substep. All loads
// are issued together. Values that are not needed here are updated by atomics instead of loads:
// dependent loads cost 1.5 % of a substep in scenes without tools.
__device__ void choose_next_dt(const GridUpdateView& d)
{
    Clock& c = *d.clock;
    Counters& all = c.counters;
    const StepBasis now = step_basis(c);
    const int active[3] = {c.active[0], c.active[1], c.active[2]}, halt = c.halt, last = c.last;
    const bool even = c.crowded[0], odd = c.crowded[1];
    const double dt_min = all.dt_min, dt_max = all.dt_max;
    Lag lag = c.lag;
    const int n = now.n, before = (n + 1) & 1, own = in_ring(n, active);
    const bool crowded = before ? odd : even;
    const Step step = now.step;
    Step next = now.next(d.limits);
    // At its bound a frame ends, whatever else: the next one finds the rim again.
    const bool bounded = n == last;
    const bool ends = (crowded || halt || bounded) && step.dt > 0 && next.dt > 0;
    if (ends) {
        c.mode = bounded ? Mode::bounded : crowded ? Mode::stopped : Mode::cut;
        c.resume = next, next.dt = 0;
    }
    // Set by a last substep: the next frame stops.
    c.crowded[before] = crowded && (bounded || !ends);
    c.set_peak(n, {});
    c.woken[n & 1] = 0;
    c.active[(n + 1) % 3] = own;
    atomicAdd(&c.drift, now.clay.speed * step.dt);
    c.step(n + 1) = next;
    c.dt[0] = float(step.dt), c.dt[1] = float(next.dt);
    publish_begun(c, n);
    if (!(step.dt > 0)) return;
    if (lag.due()) lag = {};  // the Gaussians moved after the previous substep
    lag.add(step.dt);
    c.lag = lag;
    all.dt_min = dt_min > 0 ? min(dt_min, step.dt) : step.dt;
    all.dt_max = max(dt_max, step.dt);
    atomicAdd(&all.substeps, 1);
    atomicAdd(&all.limits[int(step.limit)], 1);
    all.active_blocks = own;
}

// Thread block 0: one thread updates the clock; the other warps check whether blocks listed since
// the previous substep are on the rim. p2g checks those of a frame's first substep.
__device__ void scan_rim(const GridUpdateView& d)
{
    if (threadIdx.x == 0) choose_next_dt(d);
    if (threadIdx.x < 32) return;
    const auto start = synchronized_start<1>(d);
    if (!(start.dt > 0)) return;
    for (int k = start.before + int(threadIdx.x) - 32; k < start.count; k += int(blockDim.x) - 32)
        if (d.rim[block_of(d.list[start.n % 3][k])]) d.clock->crowded[start.n & 1] = true;
}

// A listed block with its contact flag, tools_near or tools_far; set from the mask if missing.
template <bool tools>
__device__ int noted(const GridUpdateView& d, int listed)
{
    if (!tools || listed & (tools_near | tools_far)) return listed;
    return listed | (empty(loaded(d.masks[listed])) ? tools_far : tools_near);
}

// Index of a listed block in the next substep's list, computed in a frame's first substep: blocks
// near tools are placed from the front, the others from the back. Each thread block then has at
// most one block near tools (except blocks listed later), and thread blocks that have one start
// first.
__device__ int order_by_contact(Clock& c, int listed, int count)
{
    return touched(listed) ? atomicAdd(&c.near_blocks, 1) : count - 1 - atomicAdd(&c.far_blocks, 1);
}

__device__ void look_at_guards(const GridUpdateView& d, int n)
{
    if (d.rest.mode == RestMode::sleep) guard_neighbours(d, n);
}

// Calls update(listed, early) for all listed blocks of nodes, blocks_per_cta at a time (-1: none),
// and lists them for the next substep. Before each call, clears up to blocks_per_cta blocks of the
// other grid. `early` (speculative start): the first call has early = true and one block that tools
// may touch; that update must wait for the end of the previous substep.
template <bool tools, bool fixed_point, int blocks_per_cta, class Update>
__device__ void for_each_block(const GridUpdateView& d, Start<blocks_per_cta> s, bool early,
                               Update&& update)
{
    const int *const now = d.list[s.n % 3], *const last = d.list[(s.n + 2) % 3];
    int* const next = d.list[(s.n + 1) % 3];
    const int parity = s.n & 1, stride = int(gridDim.x) - 1, fields = d.fields;
    int done = -1;
    if (!early) look_at_guards(d, s.n);
    for (int at = place(0); early || at < s.count || at < s.before;) {
        int here[blocks_per_cta], places[blocks_per_cta];  // place in the next list; -1: none
        UNROLL
        for (int& place : places) place = -1;
        if (early) {
            UNROLL
            for (int k = 0; k < blocks_per_cta; ++k) here[k] = -1;
            here[0] = done = touched(s.blocks[0]) ? s.blocks[0] : s.blocks[blocks_per_cta - 1];
        } else {
            UNROLL
            for (int k = 0; k < blocks_per_cta; ++k)
                here[k] = at + k * stride < s.count
                              ? noted<tools>(d, s.first ? block_of(s.blocks[k]) : s.blocks[k])
                              : -1;
            UNROLL
            for (int k = 0; k < blocks_per_cta; ++k) {
                const int own = at + k * stride, then = own + blocks_per_cta * stride;
                const int old = own < s.before ? block_of(s.old[k]) : -1;
                if (threadIdx.x == 0 && here[k] >= 0) {
                    if (tools && s.first)
                        places[k] = order_by_contact(*d.clock, here[k], s.count);
                    else
                        next[own] = here[k];
                    d.marks[block_of(here[k])] = listed_for(s.n + 1, false);
                }
                if (then < s.count) s.blocks[k] = now[then];
                if (then < s.before) s.old[k] = last[then];
                if (here[k] == done) here[k] = -1;
                if (old < 0) continue;
                ROLLED
                for (int i = int(threadIdx.x); i < fields * block_nodes; i += threads<tools>)
                    clear<fixed_point>(d, parity ^ 1,
                                       i / block_nodes * d.lattice.node_count() +
                                           old * block_nodes + i % block_nodes);
            }
            at += blocks_per_cta * stride;
        }
        update(here, early);
        UNROLL
        for (int k = 0; tools && k < blocks_per_cta; ++k)
            if (places[k] >= 0) next[places[k]] = here[k];
        if (!early) continue;
        early = false, s.count = d.clock->active[s.n % 3];
        look_at_guards(d, s.n);
        UNROLL
        for (int k = 0; k < blocks_per_cta; ++k)
            if (place(k) >= s.before && place(k) < s.count) s.blocks[k] = now[place(k)];
    }
}

// Shared memory of a warp, in two phases: contact near tools, then walls. Between them is a barrier
// of the warp. Warps begin at multiples of 128 bytes.
template <bool tools>
union GridScratch {
    SharedSpace contact;
    ImageSpace mirrors;
};
template <>
union GridScratch<false> {
    ImageSpace mirrors;
};
static_assert(sizeof(GridScratch<true>) == sizeof(SharedSpace) && sizeof(SharedSpace) % 128 == 0);
static_assert(sizeof(GridScratch<false>) == 7 * 32 * 16 && alignof(GridScratch<false>) == 16);

// Applies walls and the speed limit to node n, which has mass.
template <bool fixed_point>
__device__ void finish_node(const GridUpdateView& d, int substep, float dt, Int3 n,
                            MirrorNodes& mirrors, bool by_tool)
{
    if (!clear_of(n, d.walls))
        return update_with_images<fixed_point>(d, substep, dt, n, 0, mirrors, by_tool);
    bool clipped;
    mirrors.own.p = limit_speed(mirrors.own.p, d.lattice, dt, clipped);
    if (clipped) count_slowed(d, mirrors.own.m);
}

// The thread's node of the k-th listed block. Near tools a warp updates shared_nodes nodes.
struct OwnNode {
    int i;
    bool updates, near;
};
template <bool tools>
__device__ OwnNode own_node(int listed, int k)
{
    const int thread = int(threadIdx.x), lane = thread & 31, node = lane % shared_nodes;
    const int first = block_of(listed) * block_nodes;
    if (tools && touched(listed))
        return {first + (thread >> 5) * shared_nodes + node, lane == node, true};
    return {first + thread % block_nodes, thread / block_nodes == k, false};
}

// Gravity, nearby tools, walls and the speed limit for one node per lane. Warp-collective.
template <bool tools, bool fixed_point>
__device__ void update_node(const GridUpdateView& d, GridScratch<tools>& scratch, int n, float dt,
                            OwnNode own, bool early)
{
    AfterTools after{};
    if constexpr (tools)
        if (own.near) {
            const Vec3<float> x = d.lattice.position(d.lattice.node_at(own.i));
            after = near_tools<fixed_point>(d, scratch.contact, n, dt, own.i, x,
                                            d.masks[own.i / block_nodes], early);
            __syncwarp();                    // the next phase overwrites the scratch
            asm volatile("" : "+r"(own.i));  // addresses are recomputed, not kept in registers
        }
    if (!own.updates) return;
    const Int3 at = d.lattice.node_at(own.i);
    if (!own.near) after.node = sum_of<fixed_point>(d, n & 1, own.i);
    MirrorNodes mirrors(scratch.mirrors);  // loaded along with the node's sum
    if (load_mirrors<fixed_point>(d, n & 1, at, own.i, mirrors)) return;
    mirrors.own = after.node;
    if (mirrors.own.m > 0) {
        if (!own.near) mirrors.own.p = apply_gravity(mirrors.own, d.gravity, dt);
        finish_node<fixed_point>(d, n, dt, at, mirrors, after.by_tool);
    }
    node_at(d, n & 1, own.i) = mirrors.own;
}

template <class Case>
__global__ void __launch_bounds__(threads<Case::features.tools>, resident<Case::features.tools>)
    grid_kernel(const __grid_constant__ GridUpdateView d)
{
    constexpr bool tools = Case::features.tools, fixed_point = Case::features.fixed_point;
    constexpr int in_hand = blocks_per_cta<tools>;
    __shared__ GridScratch<tools> scratch[threads<tools> / 32];
    Start<in_hand> start{-1};
    if (tools && blockIdx.x > 0 && d.contact_ahead) start = speculative_start<in_hand>(d);
    const bool early = start.n >= 0;
    if (!early) {
        wait_for_previous_stage();
        if (blockIdx.x == 0) return scan_rim(d);
        start = synchronized_start<in_hand>(d);
        if (!(start.dt > 0)) return;
    }
    const int n = start.n;
    const float dt = start.dt;
    const auto update = [&](const int(&here)[in_hand], bool ahead) {
        ROLLED
        for (int k = 0; k < in_hand; ++k) {
            const int listed = k ? here[in_hand - 1] : here[0];
            if (listed < 0) continue;
            update_node<tools, fixed_point>(d, scratch[threadIdx.x >> 5], n, dt,
                                            own_node<tools>(listed, k), ahead);
        }
    };
    for_each_block<tools, fixed_point>(d, start, early, update);
}

// Direction to the clay below a blade, at node n: gradient of the mass below minus the mass above.
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

// Updates node n (index i) and its mirror nodes in one velocity field.
template <bool fixed_point, class Tools>
__device__ Node<float> updated_in(const GridUpdateView& d, int substep, float dt, Int3 n, int field,
                                  int i, MirrorNodes& mirrors, Tools&& tools)
{
    const int parity = substep & 1, first = field * d.lattice.node_count();
    const Node<float> sum = sum_of<fixed_point>(d, parity, first + i);
    if (mirrors.count() > 1 && sum.m > 0) {
        const Vec3<float> free = apply_gravity(sum, d.gravity, dt);
        mirrors.own = {tools(d.lattice.position(n), free), sum.m};
        load_mirror_sums<fixed_point>(d, parity, first, mirrors);
        update_with_images<fixed_point>(d, substep, dt, n, field, mirrors,
                                        differ(mirrors.own.p, free));
        return mirrors.own;
    }
    bool clipped;
    const Node<float> alone = update(sum, n, d.lattice, d.walls, d.gravity, dt, clipped, tools,
                                     sliding_in(d, field, substep), masses<fixed_point>(d, parity));
    if (clipped) count_slowed(d, sum.m);
    return alone;
}

// With blades: besides the velocity field of all clay, one field per label; clay labelled `above`
// and clay labelled `below` must not interpenetrate. Reads masses of neighbouring nodes, which the
// update leaves unchanged.
template <class Case>
__global__ void __launch_bounds__(block_nodes, resident_cut)
    cut_grid_kernel(const __grid_constant__ GridUpdateView d)
{
    constexpr bool fixed_point = Case::features.fixed_point;
    __shared__ ImageSpace scratch[block_nodes / 32];
    wait_for_previous_stage();
    if (blockIdx.x == 0) return scan_rim(d);
    const auto start = synchronized_start<1>(d);
    const int n = start.n, parity = n & 1, nodes = d.lattice.node_count();
    const float dt = start.dt, dx = d.lattice.dx;
    if (!(dt > 0)) return;
    const Colliders<float> colliders = d.contact.colliders(n);
    for_each_block<false, fixed_point>(d, start, false, [&](const int(&blocks)[1], bool) {
        const int b = blocks[0];
        if (b < 0) return;
        const int i = b * block_nodes + int(threadIdx.x);
        const Int3 at = d.lattice.node_at(i);
        const Mask& mask = d.masks[b];
        MirrorNodes mirrors(scratch[threadIdx.x >> 5]);
        const bool is_mirror = load_mirrors<fixed_point>(d, parity, at, i, mirrors);
        const bool clay = sum_of<fixed_point>(d, parity, i).m > 0;
        if (clay && is_mirror) return;
        if (!clay) mirrors.mirror_offset = {};
        for (int f = 0; f < 3; ++f) {
            const auto tools = [&](Vec3<float> x, Vec3<float> u) {
                if (!d.grid_contact) return u;
                u = apply_tools(colliders, mask, x, u);
                return f ? sliced(colliders, mask, x, u, dx, unsigned(f)) : u;
            };
            node_at(d, parity, f * nodes + i) =
                updated_in<fixed_point>(d, n, dt, at, f, i, mirrors, tools);
        }
        for (int k = 0; k < mirrors.count(); ++k)
            keep_apart<fixed_point>(d, parity, mirror_node(at, mirrors.mirror_offset, k));
    });
}

// The side of a blade on which field f of bodies is kept at the node with index i; uncut: neither,
// as its clay there moves with uncut clay. Updates leave all masses unchanged.
template <bool fixed_point>
__device__ unsigned sliced_side(const GridUpdateView& d, int parity, int f, int i)
{
    const int label = (f - 1) % labels_of_clay, first = f - label, nodes = d.lattice.node_count();
    if (label == int(uncut)) return uncut;
    const auto mass = [&](int k) {
        return sum_of<fixed_point>(d, parity, (first + k) * nodes + i).m;
    };
    const LabelledClay<float> clay{mass(int(uncut)), mass(int(above)), mass(int(below))};
    return clay.bridged() ? unsigned(uncut) : unsigned(label);
}

// Gives fields of a colour that act as one their common velocity, and field 0 the mean of all, at
// the node with index i.
template <bool blades>
__device__ void put_mean(const GridUpdateView& d, int parity, int i)
{
    const int nodes = d.lattice.node_count();
    if constexpr (blades) ROLLED
    for (int first = 1; first < d.fields; first += labels_of_clay)
        weld_velocities<float>(
            first, [&](int f) { return node_at(d, parity, f * nodes + i); },
            [&](int f, const Node<float>& node) { node_at(d, parity, f * nodes + i) = node; });
    Node<float> mean{};
    ROLLED
    for (int f = 1; f < d.fields; ++f) {
        const Node<float> own = node_at(d, parity, f * nodes + i);
        mean = {mean.p + own.m * own.p, mean.m + own.m};
    }
    if (mean.m > 0) mean.p = (1 / mean.m) * mean.p;
    node_at(d, parity, i) = mean;
}

// With bodies: one velocity field per colour, or with blades three, by label. Contact between them
// has changed the momenta already, and field 0 has their masses (bodies.cu); here it gets their
// mean velocity.
template <class Case>
__global__ void __launch_bounds__(block_nodes, resident_cut)
    body_grid_kernel(const __grid_constant__ GridUpdateView d)
{
    constexpr bool fixed_point = Case::features.fixed_point;
    constexpr bool blades = Case::features.blades;
    __shared__ ImageSpace scratch[block_nodes / 32];
    wait_for_previous_stage();
    if (blockIdx.x == 0) return scan_rim(d);
    const auto start = synchronized_start<1>(d);
    const int n = start.n, parity = n & 1, nodes = d.lattice.node_count();
    const float dt = start.dt;
    if (!(dt > 0)) return;
    const Colliders<float> colliders = d.contact.colliders(n);
    for_each_block<false, fixed_point>(d, start, false, [&](const int(&blocks)[1], bool) {
        const int b = blocks[0];
        if (b < 0) return;
        const int i = b * block_nodes + int(threadIdx.x);
        const Int3 at = d.lattice.node_at(i);
        const Mask& mask = d.masks[b];
        MirrorNodes mirrors(scratch[threadIdx.x >> 5]);
        const bool is_mirror = load_mirrors<fixed_point>(d, parity, at, i, mirrors);
        const bool clay = sum_of<fixed_point>(d, parity, i).m > 0;
        if (clay && is_mirror) return;
        if (!clay) mirrors.mirror_offset = {};
        ROLLED
        for (int f = 1; f < d.fields; ++f) {
            const unsigned side = blades ? sliced_side<fixed_point>(d, parity, f, i) : uncut;
            const auto tools = [&](Vec3<float> x, Vec3<float> u) {
                if (!d.grid_contact) return u;
                u = apply_tools(colliders, mask, x, u);
                if constexpr (blades)
                    if (side != uncut) u = sliced(colliders, mask, x, u, d.lattice.dx, side);
                return u;
            };
            node_at(d, parity, f * nodes + i) =
                updated_in<fixed_point>(d, n, dt, at, f, i, mirrors, tools);
        }
        ROLLED
        for (int k = 0; k < mirrors.count(); ++k) {
            const int to = mirrors.count() > 1 ? mirrors.index(k) : i;
            put_mean<blades>(d, parity, to);
        }
    });
}

constexpr Features relevant(Features f)
{
    return {.tools = f.tools, .fixed_point = f.fixed_point, .blades = f.blades, .bodies = f.bodies};
}

struct Launch {
    void (*kernel)(GridUpdateView);
    int threads, resident;
};
constexpr auto launch_for = []<class Case>(Case) -> Launch {
    constexpr Features f = Case::features;
    if constexpr (f.bodies)
        return {body_grid_kernel<Case>, block_nodes, resident_cut};
    else if constexpr (f.blades)
        return {cut_grid_kernel<Case>, block_nodes, resident_cut};
    else
        return {grid_kernel<Case>, threads<f.tools>, resident<f.tools>};
};

}  // namespace

void grid(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream,
          bool begins)
{
    Features used = features;
    used.tools = used.bodies || (used.tools && views.tools.grid_contact);
    const Launch by = dispatch<relevant>(used, launch_for);
    const int blocks = 1 + min(views.lattice.block_count(), by.resident * multiprocessors - 1);
    const unsigned allowed = begins || used.bodies ? overlap::none : views.overlaps;
    launch_early(allowed, overlap::grid, "grid", by.kernel, blocks, by.threads, stream,
                 grid_view(views));
}

}  // namespace knead::gpu
