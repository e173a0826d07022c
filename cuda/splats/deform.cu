// Kernels for Gaussians, one thread per Gaussian: one kernel moves them, another pushes them out of
// tools. In a single kernel the few Gaussians inside a tool would delay the others. The Gaussians
// of a warp lie around the same nodes, which are read from L1.
#include "cuda/mpm/gather.cuh"
#include "cuda/mpm/substep.cuh"
#include "cuda/mpm/substep_sync.cuh"
#include "cuda/splats/deform.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

struct DeformView {
    // reads
    const float4* velocities[2];  // fields * node_count each, of substep n in n % 2
    Lattice<float> lattice;
    Box3<float> free;  // see stored_region.h
    Walls<float> walls;
    ContactView contact;
    NearView near;
    const int* moves_from;  // block_count: the substep from which its clay moves; with sleep only
    float per_mass;         // of share() [1/kg]
    bool at_end;            // of the frame: moves all that lag
    bool fast;              // tools: see clears_each_time()
    // writes
    GaussianView splats;
    Clock* clock;
    // reads
    const int* colours;  // by object, with bodies: their first velocity fields
};

// Advection of all Gaussians by `substeps` substeps of dt [s] each (0: none is due), with the
// velocities and tools of substep n.
struct Stretch {
    int n, substeps;
    float dt;
};
__device__ Stretch stretch(const DeformView& d)
{
    const Clock& c = *d.clock;
    const int begun = c.begun, done = c.done;
    const float now = c.dt[0];
    const Lag lag = c.lag;
    const bool moves = d.at_end ? !lag.due() : lag.due() && now > 0;
    return {d.at_end ? done - 1 : begun, moves ? lag.substeps : 0, lag.each<float>()};
}

// Whether they are pushed out of tools in this call, moved or not.
__device__ bool clears(const DeformView& d)
{
    const Clock& c = *d.clock;
    const bool due = c.lag.due();
    if (d.at_end) return due ? !d.fast : c.lag.substeps > 0;
    return due && c.dt[0] > 0;
}

// Counted events of a Gaussian's substep: each 0 or 1.
struct Happened {
    bool stranded, projected, repaired;
};

// Index of the thread's Gaussian; also forces later reads to be issued again: reloading from L1
// costs less than keeping the values in registers.
__device__ int own_index()
{
    unsigned block, thread;
    asm volatile("mov.u32 %0, %%ctaid.x; mov.u32 %1, %%tid.x;"
                 : "=r"(block), "=r"(thread)
                 :
                 : "memory");
    return int(block * threads + thread);
}

enum class Way { still, stranded, moves };
// The velocity field at the Gaussian at x, if it moves.
template <Features f>
__device__ Way field_around(const DeformView& d, Vec3<float> x, int i, int n,
                            LinearField<float>& field)
{
    if (!contains(d.near.stored, x)) return Way::stranded;
    const Int3 base = base_node(x, d.lattice.spacing);
    if constexpr (f.rests)
        if (d.moves_from[d.lattice.block_of(base)] > n) return Way::still;
    const float4* nodes = d.velocities[n & 1];
    if constexpr (f.blades)
        nodes +=
            Gaussian<float>{.sides = d.splats.sides[i]}.label() * unsigned(d.lattice.node_count());
    if constexpr (f.bodies) nodes += d.colours[d.splats.objects[i]] * d.lattice.node_count();
    const Offsets o = offsets(d.lattice, base);
    bool held;
    field = field_at(x, d.lattice.spacing, held, [&](Int3 step) {
        const float4 v = (nodes + o.column(step))[step.z * Lattice<float>::along_z];
        return NodeShare<float>{{v.x, v.y, v.z}, __saturatef(d.per_mass * v.w)};  // share()
    });
    return held ? Way::moves : Way::stranded;
}

// Adds a warp's events to the frame's counters.
__device__ void report(Clock& clock, const Happened& happened, int substeps)
{
    const auto add = [](unsigned long long& to, bool mine, int each) {
        const unsigned lanes = __ballot_sync(all_lanes, mine);
        if (lanes && (threadIdx.x & 31) == 0)
            atomicAdd(&to, static_cast<unsigned long long>(each * __popc(lanes)));
    };
    add(clock.counters[Count::stranded], happened.stranded, substeps);
    add(clock.counters[Count::splats_projected], happened.projected, 1);
    add(clock.counters[Count::splats_repaired], happened.repaired, 1);
}

// Moves the Gaussians.
template <class Case>
__global__ void __launch_bounds__(threads, Case::features.blades || Case::features.bodies ? 5 : 6)
    follow_kernel(const __grid_constant__ DeformView d)
{
    let_next_stage_start();
    const int own = own_index();
    const bool valid = own < *d.splats.live;
    const float4 place = d.splats.row(0, min(own, d.splats.room - 1));
    asm volatile("" ::: "memory");  // loaded together with the clock, not after it
    const Stretch before = stretch(d);
    if (before.substeps == 0) return;
    LinearField<float> field;
    Way way = Way::still;
    if (valid)
        way = field_around<Case::features>(d, {place.x, place.y, place.z}, own, before.n, field);
    const int i = own_index();
    const Stretch by = stretch(d);
    Happened happened{way == Way::stranded, false, false};
    if (way != Way::still) {
        Gaussian<float> g = d.splats.load(i);
        if (way == Way::moves) carry(g, field, by.dt, by.substeps);
        if (!contains(d.free, g.x)) keep_within(g, d.walls);
        happened.repaired = !sound(g);
        if (!happened.repaired) d.splats.store(i, g);
    }
    report(*d.clock, happened, by.substeps);
}

// Pushes a Gaussian out of tools.
template <Features f>
__device__ void clear(const DeformView& d, int i, int n, Happened& happened)
{
    Gaussian<float> g{};
    d.splats.load_place(i, g);
    if (!contains(d.near.stored, g.x)) return;
    if constexpr (f.rests)
        if (d.moves_from[d.lattice.block_of(base_node(g.x, d.lattice.spacing))] > n) return;
    const Mask& mask = d.near.masks[d.lattice.block_of(d.lattice.cell_of(g.x))];
    if (empty(mask)) return;
    if constexpr (f.blades) g.sides = d.splats.sides[i];
    happened.projected =
        keep_out(g, d.contact.colliders(n), mask, d.near.passes, f.blades, d.walls, d.lattice.dx);
    happened.repaired = !sound(g);
    if (happened.repaired) return;
    d.splats.store_place(i, g);
    if constexpr (f.blades) d.splats.sides[i] = g.sides;
}

constexpr int each = 4;  // Gaussians per thread
template <class Case>
__global__ void __launch_bounds__(threads, 4) clear_kernel(const __grid_constant__ DeformView d)
{
    constexpr Features f = Case::features;
    let_next_stage_start();
    if (!clears(d)) return;
    const int n = stretch(d).n, live = *d.splats.live;
    for (int from = int(blockIdx.x) * threads; from < live; from += int(gridDim.x) * threads) {
        Happened happened{};
        const int i = from + int(threadIdx.x);
        if (i < live) clear<f>(d, i, n, happened);
        report(*d.clock, happened, 1);
    }
}

constexpr Features relevant(Features f)
{
    return {.blades = f.blades, .rests = f.rests, .bodies = f.bodies};
}

}  // namespace

void deform(const Views& views, const GaussianView& splats, float per_mass,
            const Features& features, bool at_end, cudaStream_t stream)
{
    const G2pView same = g2p_view(views);
    const DeformView view{{same.velocities[0], same.velocities[1]},
                          same.lattice,
                          same.free,
                          same.walls,
                          same.contact,
                          same.near,
                          same.rest.free,
                          per_mass,
                          at_end,
                          views.tools.fast,
                          splats,
                          views.clock,
                          views.materials.colours};
    const auto moved = dispatch<relevant>(
        features, []<class Case>(Case) -> void (*)(DeformView) { return follow_kernel<Case>; });
    launch("deform", moved, blocks_for(splats.room, threads), threads, stream, view);
    if (view.near.passes == 0 || !(at_end || view.fast)) return;
    const auto cleared = dispatch<relevant>(
        features, []<class Case>(Case) -> void (*)(DeformView) { return clear_kernel<Case>; });
    launch("deform: out of tools", cleared, blocks_for(splats.room, each * threads), threads,
           stream, view);
}

}  // namespace knead::gpu
