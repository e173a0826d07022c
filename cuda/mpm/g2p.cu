// The substep kernel: grid to particle, the particle's own update, and its scatter for the next
// substep while its state is in registers; velocities and their gradients are written to memory
// only at the end of a frame. Meanwhile, a few thread blocks pose the tools for the next substep.
#include "cuda/mpm/events.cuh"
#include "cuda/mpm/g2p.h"
#include "cuda/mpm/gather.cuh"
#include "cuda/mpm/mean_pressure.cuh"
#include "cuda/mpm/plasticity.h"
#include "cuda/mpm/pose.cuh"
#include "cuda/mpm/project.cuh"
#include "cuda/mpm/scatter.cuh"
#include "cuda/mpm/sleep.cuh"
#include "cuda/mpm/stages.cuh"
#include "cuda/mpm/substep.cuh"
#include "cuda/mpm/substep_sync.cuh"
#include "cuda/mpm/yield.cuh"

namespace knead::gpu {
namespace {

// Whether the return map is needed by any lane of the warp: the cheaper test, used where registers
// allow.
template <Features f>
__device__ bool may_yield(const Materials& materials, const Particle<float>& q)
{
    if constexpr (f.tools && f.plasticity == PlasticityClass::plastic) {
        const Material<float> m = material_of<f>(materials, q.object);
        const bool may = m.plasticity == Plasticity::von_mises && !surely_elastic(m, q.e, q.k);
        return __any_sync(all_lanes, may);
    }
    return true;
}

// The rest of a particle's state is loaded at once, not after the velocities.
template <Features f>
constexpr bool early = f.blades || f.rests || f.mean_pressure || f.bodies;

// For cell-averaged pressure.
template <Features f>
__device__ void apply_mean_pressure_shared(const G2pView& d, Particle<float>& q, int n)
{
    if constexpr (f.mean_pressure)
        share_pressure(d.pressure, d.lattice, q, material_of<f>(d.materials, q.object), n);
}

// Shared memory of a thread block: of warps with particles, or of a thread block that poses tools.
template <bool blades>
union BlockScratch {
    WarpScratch<blades> warps;
    PoseSpace pose;
};
static_assert(sizeof(PoseSpace) <= sizeof(WarpScratch<true>));

// The masses around a particle [kg]: in registers or, if these are `full`, in scratch memory.
template <bool full>
struct Masses {
    GatherPhase& scratch;
    const unsigned lane = threadIdx.x & 31;
    float nearest = 0, around = 0;

    __device__ void at_node(float mass) { (full ? scratch.nearest_mass[lane] : nearest) = mass; }
    __device__ void add(int plane, float mass)
    {
        if constexpr (full)
            scratch.plane_mass[plane][lane] = mass;
        else
            around += mass;
    }
    __device__ float node() const { return full ? scratch.nearest_mass[lane] : nearest; }
    __device__ float cell() const
    {
        if constexpr (!full) return around;
        return scratch.plane_mass[0][lane] + scratch.plane_mass[1][lane] +
               scratch.plane_mass[2][lane];
    }
    // Before a repeated read; else the value would be kept in a register.
    __device__ void again() const
    {
        if constexpr (full) asm volatile("" ::: "memory");
    }
};

// Advances the thread's particle with the velocities of substep n. All lanes of a warp stay
// converged: still clay is advanced, too, and restored.
template <Features f>
__device__ Events advance_particle(const G2pView& d, const SubstepContext& later,
                                   BlockScratch<shares_fields(f)>& scratch, Particle<float>& q)
{
    const int n = later.n - 1;
    // Stored state of the particle. The address is rematerialised: keeping it costs registers.
    const auto particles = [&]() -> const ParticleView& { return d.particles[later.side]; };
    const auto own = [&] { return own_index<f>(later, d.particles[0].count); };
    if constexpr (early<f>) particles().load_strain(own().at, q);
    const float4* nodes = nodes_for<f.blades, f.bodies>(d, q, n);
    const Stencil<float> s = stencil(q.x, d.lattice.spacing);
    [[maybe_unused]] Quiet quiet{};
    if constexpr (f.rests) {
        quiet = quiet_at(d, q, s.base, n);
        if (__all_sync(all_lanes, quiet.unasked)) return {};
    }
    apply_mean_pressure_shared<f>(d, q, n);
    constexpr bool full = f.tools && f.plasticity != PlasticityClass::any && !early<f>;
    GatherPhase& aside = scratch.warps.gather();
    Masses<full> mass{aside};
    if constexpr (full) aside.k[mass.lane] = q.k;
    if constexpr (full && f.mixed) aside.x_z[mass.lane] = q.x.z;
    gather_from<f.tools>(
        nodes, d.lattice, s, q, [&](float m) { mass.at_node(m); },
        [&](int plane, float m) { mass.add(plane, m); },
        [&] {
            if (!early<f>) particles().load_strain(own().at, q);
            if (full) q.k = aside.k[mass.lane];
            if (full && f.mixed) q.x.z = aside.x_z[mass.lane];
        });
    bool moves = true;
    if constexpr (f.rests) {
        wake_if_pushed(d, quiet, q, later.now, n);
        moves = !q.still();
        if (!moves) q.v = {}, q.C = {};
        if (!__any_sync(all_lanes, moves)) return {};
    }
    const auto unit = [&] { return mass_of<f>(d.materials, q.object); };
    // By vote where registers allow: divergent lanes cost the warp more.
    const bool crumb = mass.node() < unit();
    if (f.tools ? __any_sync(all_lanes, crumb) : crumb)
        mass.again(), damp_isolated_particle(q.C, mass.node() / unit());
    const auto per_cell = [&] {
        mass.again();
        return mass.cell() * (f.mixed ? 1 / unit() : d.materials.per_mass);
    };
    q.e = advance_b(q.e, q.C, later.now);
    q.x = q.x + later.now * q.v;
    Events happened{};
    project<f>(q, per_cell, d, later, scratch.warps.projection(), moves, happened);
    if (may_yield<f>(d.materials, q))
        happened.yielded = yield(q, material_of<f>(d.materials, q.object), later.now);
    if (!sound(q)) {
        if (own().valid && moves) atomicAdd(&later.clock().counters[Count::repaired], 1ull);
        repair(q, particles().load_state(own().at));
    }
    if constexpr (f.rests) {
        if (!moves) q = particles().load_state(own().at), happened = {};
        happened.moved = moves;
    }
    return happened;
}

// Advances the clock to substep n and sets the loop condition of the graph. By one thread.
__device__ void move_on(const G2pView& d, int n)
{
    d.clock->done = n;
    if (d.captured) cudaGraphSetConditional(d.again, d.clock->step(n).dt > 0);
}

// Thread blocks per multiprocessor: as many as registers allow without spilling, limited by shared
// memory.
constexpr int max_resident = SHARED_KIB / 25;
template <Features f>
constexpr int spill_free = f.rests
                               ? (f.plasticity == PlasticityClass::any || SHARED_KIB < 228 ? 3 : 5)
                           : shares_fields(f)                     ? 6
                           : f.plasticity == PlasticityClass::any ? 3
                           : f.mean_pressure                      ? (f.tools ? 5 : 4)
                           : f.tools                              ? 7
                                                                  : 8;
template <Features f>
constexpr int resident = spill_free<f> < max_resident ? spill_free<f> : max_resident;

// Substep of a run, by all threads of a block: advances the thread's particle, stores it, and
// scatters it for the next substep.
template <Features f, int warps>
__device__ void advance_run(const G2pView& d, const SubstepContext& later,
                            BlockScratch<shares_fields(f)>& scratch, Sums (&sums)[warps],
                            Particle<float>& q)
{
    Events happened = advance_particle<f>(d, later, scratch, q);
    const ParticleView& to = d.particles[later.side];
    const Index own = own_index<f>(later, to.count);
    if (!own.valid) happened = {};
    const bool far = happened.depth > d.lattice.dx, sudden = abrupt(q.C, later.now) && own.valid;
    if (__any_sync(all_lanes, far || sudden)) {
        if (far) atomicAdd(&later.clock().counters[Count::moved_far], 1ull);
        if (sudden) atomicAdd(&later.clock().counters[Count::abrupt], 1ull);
    }
    Material<float> m = material_of<f>(d.materials, q.object);
    const float per_density = f.mixed ? 1 / m.density : d.materials.per_density;
    const Sums all = summed<f.tools>(happened, speed_that_counts(dot(q.v, q.v), happened.depth),
                                     stiffness(q, m, per_density));
    if ((threadIdx.x & 31) == 0) sums[threadIdx.x >> 5] = all;
    const bool last = !(later.dt > 0);
    if constexpr (f.rests) note_end(d, q, last && happened.moved, later.n - 1);
    if (own.valid) to.store_state(own.at, q);
    if (own.valid && last) to.store_motion(own.at, q);
    WarpScatter<shares_fields(f), false, f.bodies> scatter{d, scratch.warps, later.n};
    if constexpr (f.mean_pressure)
        if (own.valid && !last) add_pressure(d.pressure, d.lattice, q, m, later.n);
    const bool heavy = f.rests && stands(d.rest.options.mode, q);
    if (heavy) q.v = held_rise(d.rest.gravity, later.dt), m = as_held(m);
    const float per_mass = f.mixed || heavy ? 1 / m.mass : d.materials.per_mass;
    const int field = field_of<f>(d.materials, q);
    if (!last) scatter(q, m, per_mass, own.valid, later.dt, field);
    const int own_activity = synchronised<f.rests>(happened.moved);
    if (threadIdx.x == 0) report(later.clock(), later.n - 1, sums, own_activity);
}

// Poses the thread block's part of the tools for the next substep as soon as its length is chosen,
// while grid may still run, if both are not empty.
__device__ void pose_next(const G2pView& d, PoseSpace& scratch)
{
    if (!d.pose_ahead) wait_for_velocities();
    take_view(d.pose, scratch);
    Clock& clock = *d.clock;
    const int part = int(blockIdx.x), n = __ldcg(&clock.done);
    wait_for_begun(clock, n);
    if (!(clock.dt[0] > 0 && clock.dt[1] > 0)) return;
    pose_part(scratch, part, n + 1);
    publish_posed(clock, part, n + 1);
}

template <class Case>
__global__ void __launch_bounds__(run_length(Case::features), resident<Case::features>)
    g2p_kernel(const __grid_constant__ G2pView d)
{
    constexpr Features f = Case::features;
    __shared__ BlockScratch<shares_fields(f)> scratch;
    __shared__ Sums sums[scatter_warps<shares_fields(f)>];
    __shared__ SubstepContext later;
    const Clock& clock = *d.clock;
    constexpr bool rests = f.rests;
    constexpr int pose_blocks = f.tools ? pose_parts : 0;
    if constexpr (f.tools)
        if (int(blockIdx.x) < pose_blocks) return pose_next(d, scratch.pose);
    wait_for_velocities();
    const int count = d.particles[0].count, side = clock.side, n = clock.begun;
    const float dt = clock.dt[0], after = clock.dt[1];
    int run = int(blockIdx.x) - pose_blocks;
    if (f.tools && !f.rests) run = d.runs[run];
    // Only dt can be; the others are tested so that all loads are issued together.
    if (!(dt > 0) || after < 0 || n < 0 || side < 0 || run < 0) return;
    let_next_stage_start();
    Particle<float> q{};
    if constexpr (!f.rests) d.particles[side].load_place(index_in<f>(run, count).at, q);
    if (threadIdx.x == 0) later = {d.clock, n + 1, side, dt, after, f.rests ? 0 : run};
    __syncthreads();
    for_each_run<f.rests>(clock, d.listed, pose_blocks, run, [&](int listed) {
        if constexpr (rests) {
            if (threadIdx.x == 0) later.run = listed;
            q = {}, d.particles[later.side].load_place(index_in<f>(listed, count).at, q);
            __syncthreads();
        }
        advance_run<f>(d, later, scratch, sums, q);
    });
    // Last: after it, ptxas no longer treats the warp as converged.
    if (threadIdx.x == 0 && int(blockIdx.x) == pose_blocks) move_on(d, later.n);
}

constexpr Features relevant(Features f)
{
    f.fixed_point = false;  // tested at run time
    return f;
}

struct Launch {
    void (*kernel)(G2pView);
    int pose_blocks;
};
constexpr auto launch_for = []<class Case>(Case) -> Launch {
    return {g2p_kernel<Case>, Case::features.tools ? pose_parts : 0};
};

}  // namespace

void g2p(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream)
{
    const Launch by = dispatch<relevant>(features, launch_for);
    launch_early(
        views.overlaps, overlap::g2p, "g2p", by.kernel,
        blocks_for_runs(views.particles[0].count, features, multiprocessors) + by.pose_blocks,
        run_length(features), stream, g2p_view(views));
}

}  // namespace knead::gpu
