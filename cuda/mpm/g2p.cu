// The kernel that a substep is: grid to particle, all that a particle does by itself, and its
// scatter for the substep to come, while its numbers are still at hand: velocities and their
// gradients go to memory only when the frame ends. A few blocks pose the tools for that substep
// meanwhile.
#include "cuda/contact/cut.h"
#include "cuda/device/launch.cuh"
#include "cuda/mpm/g2p.h"
#include "cuda/mpm/plasticity.h"
#include "cuda/mpm/pose.cuh"
#include "cuda/mpm/project.cuh"
#include "cuda/mpm/scatter.cuh"
#include "cuda/mpm/stages.cuh"

namespace knead::gpu {
namespace {

// What happened to one particle.
struct Events {
    unsigned yielded, projected, confined, covered, moved;  // 0 or 1
    float depth;
};

// A new frame, or what is left of one.
__device__ void begin_frame(const Views& d)
{
    Clock& c = *d.clock;
    c.duration = d.input->duration;
    c.tool_step = d.input->tool_step;
    const double speed = sqrt(double(__uint_as_float(c.fastest[(c.done + 1) & 1])));
    const bool anew = c.mode == Mode::running;
    c.step(c.done) = anew ? step_at(d.limits, 0, speed, c.tool_step, c.duration) : c.resume;
    if (anew) c.counters = {};
    c.near_runs = c.far_runs = 0;
    c.active[c.done % 3] = 0;
    c.crowded[0] = c.crowded[1] = false;
    c.mode = Mode::running;
}

__global__ void begin_kernel(const __grid_constant__ Views d)
{
    Clock& c = *d.clock;
    if (c.mode != Mode::stopped) begin_frame(d);
    // Where clay may be still, the sort says whose it is.
    c.unsorted = c.mode == Mode::running &&
                 (d.rest.rule.mode != RestMode::none || c.drift > max_drift * d.limits.dx);
    if (!d.captured) return;
    cudaGraphSetConditional(d.unsorted[c.side ^ 1], false);
    cudaGraphSetConditional(d.unsorted[c.side], c.unsorted);  // after: it may be the same
    cudaGraphSetConditional(d.again, c.mode == Mode::running);
}

template <PlasticityClass plasticity>
__device__ Material<float> narrowed(Material<float> m)
{
    if constexpr (plasticity != PlasticityClass::any) m.elasticity = Elasticity::neo_hookean;
    if constexpr (plasticity == PlasticityClass::elastic) m.plasticity = Plasticity::none;
    if constexpr (plasticity == PlasticityClass::plastic)
        m.plasticity =
            m.plasticity == Plasticity::von_mises ? Plasticity::von_mises : Plasticity::none;
    return m;
}

// A particle moves in block b, or will, whose clay was still in substep n: where clay may wake, the
// block's moves from the next substep on.
__device__ void wake(const Views& d, int b, int n)
{
    const RestView& r = d.rest;
    r.changed[b] = n + 1;
    if (r.rule.mode != RestMode::sleep || atomicMin(&r.free[b], n + 1) != never) return;
    r.woken[n & 1][atomicAdd(&d.clock->woken[n & 1], 1)] = b;
    if (r.range[b].x < r.range[b].y) atomicAdd(&d.clock->counters.woken, 1ull);
}

// Where a particle has come to in the frame's last substep n, after which nobody looks.
__device__ void note_end(const Views& d, const Particle<float>& q, bool ends, int n)
{
    if (ends) d.rest.changed[d.lattice.block_of(base_node(q.x, d.lattice.spacing))] = n + 1;
}

// What is known of a particle where clay may be still, before it is looked at: the block of its
// stencil's base, whether that block's clay is still in this substep, whether nobody looks here.
struct Quiet {
    int block;
    bool still, unasked;
};
__device__ Quiet quiet_at(const Views& d, Particle<float>& q, Int3 base, int n)
{
    Quiet at{d.lattice.block_of(base), false, false};
    at.still = d.rest.free[at.block] > n;
    if (!at.still) q.hold(false);
    at.unasked = q.still() && d.rest.guard[at.block] > n;
    return at;
}

// The thread's particle of a run; of the last run's end the last one again and again.
struct Index {
    int at;
    bool valid;  // false: again
};
template <bool blades>
__device__ Index index_in(int run, int count)
{
    const int i = run * scatter_threads<blades> + int(threadIdx.x);
    return {min(max(i, 0), count - 1), i < count};
}

// The same, found anew: to keep it would cost a register.
template <bool tools, bool blades>
__device__ Index own_index(const SubstepContext& later, int count)
{
    return index_in<blades>(tools ? later.run : int(blockIdx.x), count);
}

// Moves the thread's particle through the velocities of substep n. All lanes of a warp stay
// together: clay that is still moves, too, and is put back.
template <bool tools, PlasticityClass plasticity, bool blades, bool rests>
__device__ Events moved(const Views& d, const SubstepContext& later, ScatterSpace<blades>& space,
                        Particle<float>& q)
{
    constexpr bool early = blades || rests;  // what is left of the state is asked for at once
    const int n = later.n - 1;
    // What was stored of the particle, found anew: keeping where costs registers.
    const auto particles = [&]() -> const ParticleView& { return d.particles[later.side]; };
    const auto own = [&] { return own_index<tools, blades>(later, d.particles[0].count); };
    if constexpr (early) particles().load_strain(own().at, q);
    const float4* nodes = d.grid.nodes[n & 1];
    if constexpr (blades) nodes += q.label() * unsigned(d.lattice.node_count());
    const Stencil<float> s = stencil(q.x, d.lattice.spacing);
    [[maybe_unused]] Quiet quiet{};
    if constexpr (rests) {
        quiet = quiet_at(d, q, s.base, n);
        if (__all_sync(all_lanes, quiet.unasked)) return {};
    }
    const Offsets o = offsets(d.lattice, s.base);
    // The one number that the registers have no room for meanwhile.
    constexpr bool full = tools && plasticity == PlasticityClass::plastic && !early;
    float* const aside = &space.slopes[threadIdx.x >> 5][0][0].x + (threadIdx.x & 31);
    if constexpr (full) *aside = q.k;
    gather(q, s, d.lattice.spacing, [&](Int3 step) {
        // Loads of one plane at a time, and what is not asked for yet with the last: of all at once
        // the results would fill the registers.
        if (step.y == 0 && step.z == 0) __syncwarp();
        if (!early && step == Int3{2, 0, 0}) {
            particles().load_strain(own().at, q);
            if (full) q.k = *aside;
        }
        const float4 v = (nodes + o.column(step))[step.z * Lattice<float>::along_z];
        return Vec3<float>{v.x, v.y, v.z};
    });
    bool moves = true;
    if constexpr (rests) {
        const bool wakes = !q.still() || pushed(d.rest.rule, q.v, later.now);
        if (quiet.still && !quiet.unasked && wakes) wake(d, quiet.block, n);
        moves = !q.still();
        if (!moves) q.v = {}, q.C = {};
        if (!__any_sync(all_lanes, moves)) return {};
    }
    const float dt = later.now;
    q.e = advance_b(q.e, q.C, dt);
    q.x = q.x + dt * q.v;
    Events happened{};
    if constexpr (tools)
        happened.depth =
            left_tools<blades>(q, d, later, ContactScratch<blades>{space}, moves, happened.covered);
    happened.projected = happened.depth > 0;
    if (!d.free.holds(q.x)) {
        happened.confined = confine(q, d.walls);
        q.x = d.stored.nearest(q.x);
    }
    happened.yielded = yield(q, narrowed<plasticity>(d.materials[q.object]), later.now);
    if (!sound(q)) {
        if (own().valid && moves) atomicAdd(&later.clock().counters.repaired, 1ull);
        repair(q, particles().load_state(own().at));
    }
    if constexpr (rests) {
        if (!moves) q = particles().load_state(own().at), happened = {};
        happened.moved = moves;
    }
    return happened;
}

// What happened in one warp, on its way to the frame's counters: how many particles yielded, were
// projected, were confined and were covered by a blade, a byte each; bits of the largest numbers.
struct Sums {
    unsigned events, deepest, fastest;
};

template <bool tools>
__device__ Sums summed(const Events& e, float speed_squared)
{
    const unsigned mine =
        e.yielded + (e.projected << 8) + (e.confined << 16) + (unsigned(e.covered) << 24);
    // Of numbers that are not negative the largest has the largest bits.
    return {__reduce_add_sync(all_lanes, mine),
            tools ? __reduce_max_sync(all_lanes, __float_as_uint(e.depth)) : 0,
            __reduce_max_sync(all_lanes, __float_as_uint(speed_squared))};
}

// Waits for the thread block; how many of its threads say `counted`, if that is asked.
template <bool asked>
__device__ int synchronised(bool counted)
{
    if constexpr (asked) return __syncthreads_count(counted);
    __syncthreads();
    return 0;
}

// The warps' events to the counters of substep n; by one thread.
template <int warps>
__device__ void report(Clock& clock, int n, const Sums (&sums)[warps], int moved)
{
    if (moved) atomicAdd(&clock.counters.moved, static_cast<unsigned long long>(moved));
    Sums all{};
    UNROLL
    for (const Sums& s : sums)  // 128 particles: no byte runs over
        all = {all.events + s.events, max(all.deepest, s.deepest), max(all.fastest, s.fastest)};
    unsigned long long* to[] = {&clock.counters.yielded, &clock.counters.projected,
                                &clock.counters.confined, &clock.counters.covered};
    UNROLL
    for (int k = 0; k < 4; ++k) {
        const unsigned some = all.events >> (8 * k) & 255;
        if (some) atomicAdd(to[k], static_cast<unsigned long long>(some));
    }
    if (all.deepest) atomicMax(&clock.counters.deepest, all.deepest);
    atomicMax(&clock.fastest[n & 1], all.fastest);
}

// By one thread: what substep n goes by, which comes next.
__device__ void move_on(const Views& d, int n)
{
    d.clock->done = n;
    if (d.captured) cudaGraphSetConditional(d.again, d.clock->step(n).dt > 0);
}

// Blocks per multiprocessor: as many as leave registers enough to spill nothing, and no more than
// shared memory holds.
constexpr int max_resident = SHARED_KIB / 25;
template <bool tools, PlasticityClass plasticity, bool blades, bool rests>
constexpr int spill_free = rests ? (plasticity == PlasticityClass::any || SHARED_KIB < 228 ? 3 : 5)
                           : blades                             ? 6
                           : plasticity == PlasticityClass::any ? 3
                           : tools                              ? 7
                                                                : 8;
template <bool tools, PlasticityClass plasticity, bool blades, bool rests>
constexpr int resident = spill_free<tools, plasticity, blades, rests> < max_resident
                             ? spill_free<tools, plasticity, blades, rests>
                             : max_resident;

// The substep of a run, by all threads of a block: the thread's particle is stored, and scattered
// for the next.
template <bool tools, PlasticityClass plasticity, bool blades, bool rests, int warps>
__device__ void stepped(const Views& d, const SubstepContext& later, ScatterSpace<blades>& space,
                        Sums (&sums)[warps], Particle<float>& q)
{
    Events happened = moved<tools, plasticity, blades, rests>(d, later, space, q);
    const ParticleView& to = d.particles[later.side];
    const Index own = own_index<tools, blades>(later, to.count);
    if (!own.valid) happened = {};
    const Sums all = summed<tools>(happened, dot(q.v, q.v));
    if ((threadIdx.x & 31) == 0) sums[threadIdx.x >> 5] = all;
    const bool last = !(later.dt > 0);
    if constexpr (rests) note_end(d, q, last && happened.moved, later.n - 1);
    if (own.valid) to.store_state(own.at, q);
    if (own.valid && last) to.store_motion(own.at, q);
    WarpScatter<blades> scatter{d, space, later.n};
    if (!last) scatter(q, narrowed<plasticity>(d.materials[q.object]), own.valid, later.dt);
    const int own_activity = synchronised<rests>(happened.moved);
    if (threadIdx.x == 0) report(later.clock(), later.n - 1, sums, own_activity);
}

template <bool tools, PlasticityClass plasticity, bool blades, bool rests>
__global__ void __launch_bounds__(scatter_threads<blades>,
                                  (resident<tools, plasticity, blades, rests>))
    g2p_kernel(const __grid_constant__ Views d)
{
    union Space {
        ScatterSpace<blades> scatter;
        PoseSpace pose;
    };
    __shared__ Space space;
    __shared__ Sums sums[scatter_warps<blades>];
    __shared__ SubstepContext later;
    const Clock& clock = *d.clock;
    constexpr int pose_blocks = tools ? pose_parts : 0;
    const int count = d.particles[0].count, side = clock.side;
    // What the substep before left of the particles is there long before this one's velocities.
    Particle<float> q{};
    int run = int(blockIdx.x) - pose_blocks;
    if constexpr (!rests) {
        if (tools && run >= 0) run = d.tools.runs[run];
        d.particles[side].load_place(index_in<blades>(run, count).at, q);
    }
    wait_for_upstream();
    const int n = clock.begun;
    const float dt = clock.dt[0], after = clock.dt[1];
    // None is ever below zero; asked, for all to be read at once rather than one after the other.
    if (!(dt > 0) || after < 0 || n < 0) return;
    if (tools && int(blockIdx.x) < pose_blocks) {
        if (after > 0) pose_part(d, space.pose, int(blockIdx.x), n + 1);
        return;
    }
    if (threadIdx.x == 0) later = {d.clock, n + 1, side, dt, after, rests ? 0 : run};
    __syncthreads();
    for_each_run<rests>(d, pose_blocks, run, [&](int listed) {
        if constexpr (rests) {
            if (threadIdx.x == 0) later.run = listed;
            q = {}, d.particles[later.side].load_place(index_in<blades>(listed, count).at, q);
            __syncthreads();
        }
        stepped<tools, plasticity, blades, rests>(d, later, space.scatter, sums, q);
    });
    // Last, for ptxas does not know that the warp is together again after it.
    if (threadIdx.x == 0 && int(blockIdx.x) == pose_blocks) move_on(d, later.n);
}

template <bool tools>
auto kernel_for(PlasticityClass plasticity)
{
    return plasticity == PlasticityClass::elastic
               ? g2p_kernel<tools, PlasticityClass::elastic, false, false>
           : plasticity == PlasticityClass::plastic
               ? g2p_kernel<tools, PlasticityClass::plastic, false, false>
               : g2p_kernel<tools, PlasticityClass::any, false, false>;
}

// Scenes with blades, or in which clay may be still, have tools or run as if they had.
auto kernel_for(const Features& features)
{
    if (features.blades)
        return features.rests ? g2p_kernel<true, PlasticityClass::any, true, true>
                              : g2p_kernel<true, PlasticityClass::any, true, false>;
    if (features.rests)
        return features.plasticity == PlasticityClass::any
                   ? g2p_kernel<true, PlasticityClass::any, false, true>
                   : g2p_kernel<true, PlasticityClass::plastic, false, true>;
    return features.tools ? kernel_for<true>(features.plasticity)
                          : kernel_for<false>(features.plasticity);
}

}  // namespace

void begin(const Views& views, cudaStream_t stream)
{
    launch("begin", begin_kernel, 1, 1, stream, views);
}

void g2p(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream)
{
    const int pose_blocks = features.tools || features.blades || features.rests ? pose_parts : 0;
    launch_pdl("g2p", kernel_for(features),
               blocks_for_runs(views, features, multiprocessors) + pose_blocks,
               run_length(features), stream, views);
}

}  // namespace knead::gpu
