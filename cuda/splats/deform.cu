// One thread a Gaussian. A warp's lie around the same nodes, which come from L1.
#include "cuda/device/launch.cuh"
#include "cuda/mpm/gather.cuh"
#include "cuda/mpm/substep.cuh"
#include "cuda/splats/deform.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

struct DeformView {
    // reads
    const float4* velocities[2];  // fields * node_count each: that of substep n, in n % 2
    Lattice<float> lattice;
    Region free;  // see stored_region.h
    Walls<float> walls;
    ContactView contact;
    NearView near;
    const int* moves_from;  // block_count: where clay may be still, from which substep on it moves
    float per_mass;         // of share() [1/kg]
    bool at_end;            // of the frame: whoever is behind is moved
    // writes
    GaussianView splats;
    Clock* clock;
};

// By how much they move: through so many substeps of dt [s] each, 0 where they are not behind or it
// is not their turn; by velocities and tools of substep n.
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

// What of a Gaussian's substep is counted: each 0 or 1.
struct Happened {
    bool stranded, projected, repaired;
};

// Where clay moves g; what is left of it is loaded meanwhile. False: it is held still.
template <Features f>
__device__ bool follow(const DeformView& d, Gaussian<float>& g, int i, const Stretch& by,
                       bool& stranded)
{
    stranded = !d.near.stored.holds(g.x);
    if (stranded) return d.splats.load_rest(i, g), true;
    const Int3 base = base_node(g.x, d.lattice.spacing);
    if constexpr (f.rests)
        if (d.moves_from[d.lattice.block_of(base)] > by.n) return false;
    const float4* nodes = d.velocities[by.n & 1];
    if constexpr (f.blades) nodes += g.label() * unsigned(d.lattice.node_count());
    const Offsets o = offsets(d.lattice, base);
    bool held;
    const LinearField<float> field = field_at(g.x, d.lattice.spacing, held, [&](Int3 step) {
        const float4 v = (nodes + o.column(step))[step.z * Lattice<float>::along_z];
        return NodeShare<float>{{v.x, v.y, v.z}, __saturatef(d.per_mass * v.w)};  // share()
    });
    d.splats.load_rest(i, g);
    if (held) carry(g, field, by.dt, by.substeps);
    stranded = !held;
    return true;
}

// Out of what it must not be in; true if a tool moved it.
template <Features f>
__device__ bool put_right(const DeformView& d, Gaussian<float>& g, int n)
{
    if constexpr (f.tools)
        if (d.near.passes > 0 && d.near.stored.holds(g.x)) {
            const Mask& mask = d.near.masks[d.lattice.block_of(d.lattice.cell_of(g.x))];
            if (!empty(mask))
                return keep_out(g, d.contact.colliders(n), mask, d.near.passes, f.blades, d.walls,
                                d.lattice.dx);
        }
    if (!d.free.holds(g.x)) keep_within(g, d.walls);
    return false;
}

// A warp's to the frame's counters.
__device__ void report(Clock& clock, const Happened& happened, int substeps)
{
    const auto add = [](unsigned long long& to, bool mine, int each) {
        const unsigned lanes = __ballot_sync(all_lanes, mine);
        if (lanes && (threadIdx.x & 31) == 0)
            atomicAdd(&to, static_cast<unsigned long long>(each * __popc(lanes)));
    };
    add(clock.counters.stranded, happened.stranded, substeps);
    add(clock.counters.splats_projected, happened.projected, 1);
    add(clock.counters.splats_repaired, happened.repaired, 1);
}

template <class Case>
__global__ void __launch_bounds__(threads, 5) deform_kernel(const __grid_constant__ DeformView d)
{
    constexpr Features f = Case::features;
    const int own = int(blockIdx.x * threads + threadIdx.x), i = min(own, d.splats.room - 1);
    const bool valid = own < *d.splats.live;
    // As it was left when it moved last, in a substep that is over.
    Gaussian<float> g{};
    d.splats.load_place(i, g);
    if constexpr (f.blades) g.sides = d.splats.sides[i];
    wait_for_upstream();
    const Stretch by = stretch(d);
    if (by.substeps == 0) return;
    Happened happened{};
    if (valid && follow<f>(d, g, i, by, happened.stranded)) {
        happened.projected = put_right<f>(d, g, by.n);
        happened.repaired = !sound(g);
        if (!happened.repaired) {
            d.splats.store(i, g);
            if constexpr (f.blades) d.splats.sides[i] = g.sides;
        }
    }
    report(*d.clock, happened, by.substeps);
}

constexpr Features relevant(Features f)
{
    return {.tools = f.tools, .blades = f.blades, .rests = f.rests};
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
                          splats,
                          views.clock};
    const auto kernel = dispatch<relevant>(
        features, []<class Case>(Case) -> void (*)(DeformView) { return deform_kernel<Case>; });
    const int blocks = blocks_for(splats.room, threads);
    if (at_end)  // behind a loop, where none starts early
        launch("deform", kernel, blocks, threads, stream, view);
    else
        launch_pdl("deform", kernel, blocks, threads, stream, view);
}

}  // namespace knead::gpu
