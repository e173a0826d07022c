// Grid to particle, and all that a particle does by itself before the next scatter: it moves, is
// strained, leaves tools and walls, flows. The last block to finish chooses the next substep.
#include "blade.h"
#include "g2p.h"
#include "launch.cuh"
#include "plasticity.h"
#include "project.h"
#include "stages.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;
constexpr unsigned all_lanes = 0xffffffffu;

// What happened to one particle.
struct Events {
    bool yielded, projected, confined, repaired, covered;
    float depth, speed_squared;
};

// Chooses the substep from here to the frame's end; false if there is none left.
__device__ bool plan(const Views& d)
{
    Clock& c = *d.clock;
    const double left = c.duration - c.elapsed;
    if (!(left > 1e-12 * c.duration)) return false;
    const StepChoice step = paced(d.pace, sqrt(c.speed_squared), c.tool_step, left);
    c.dt = step.dt;
    c.limit = int(step.limit);
    return true;
}

__global__ void begin_kernel(const __grid_constant__ Views d)
{
    Clock& c = *d.clock;
    c.duration = d.orders->duration;
    c.tool_step = d.orders->tool_step;
    c.elapsed = 0;
    c.counters = {};
    plan(d);
}

// Run by one thread when every particle has moved.
__device__ void finish(const Views& d)
{
    Clock& c = *d.clock;
    Counters& n = c.counters;
    n.dt_least = n.substeps ? least(n.dt_least, c.dt) : c.dt;
    n.dt_most = most(n.dt_most, c.dt);
    ++n.substeps;
    ++n.limits[c.limit];
    n.active_blocks = c.active[c.parity];
    c.active[c.parity ^ 1] = 0;
    c.parity ^= 1;
    c.speed_squared = double(__uint_as_float(atomicExch(&c.fastest, 0u)));
    c.finished = 0;
    c.elapsed += c.dt;
    const bool again = plan(d);
    if (d.looped) cudaGraphSetConditional(d.again, again);
}

template <Flows flows>
__device__ Material<float> narrowed(Material<float> m)
{
    if constexpr (flows != Flows::any) m.elasticity = Elasticity::neo_hookean;
    if constexpr (flows == Flows::elastic) m.flow = Flow::none;
    if constexpr (flows == Flows::plastic)
        m.flow = m.flow == Flow::von_mises ? Flow::von_mises : Flow::none;
    return m;
}

template <bool blades>
__device__ float left_tools(Particle<float>& q, const Views& d, bool& covered)
{
    const float dx = d.lattice.dx;
    const Int3 cell = {int(q.x.x / dx), int(q.x.y / dx), int(q.x.z / dx)}, size = d.lattice.size;
    if (d.tools.passes == 0 || cell.x < 0 || cell.y < 0 || cell.z < 0 || cell.x >= size.x ||
        cell.y >= size.y || cell.z >= size.z)
        return 0;
    const Mask& mask = d.tools.masks[d.lattice.block_of(cell)];
    if constexpr (blades) covered = cut(q, d.tools.colliders(), mask, dx);
    return project(q, d.tools.colliders(), mask, d.tools.passes);
}

template <bool tools, Flows flows, bool blades>
__device__ Events moved(const Views& d, const ParticleView& particles, int i)
{
    Particle<float> q = particles.load(i);
    const float dt = float(d.clock->dt);
    const float4* nodes = d.grid.nodes[d.clock->parity];
    if constexpr (blades) nodes += q.sides * unsigned(d.lattice.node_count());
    const Stencil<float> s = stencil(q.x, d.lattice.dx);
    const Offsets o = offsets(d.lattice, s.base);
    gather(q, s, d.lattice.dx, [&](Int3 step) {
        const float4 n = nodes[o.at(step)];
        return Vec3<float>{n.x, n.y, n.z};
    });
    q.e = strained(q.e, q.C, dt);
    q.x = q.x + dt * q.v;
    Events happened{};
    if constexpr (tools) happened.depth = left_tools<blades>(q, d, happened.covered);
    happened.projected = happened.depth > 0;
    happened.confined = confine(q, d.lattice, d.walls);
    happened.yielded = yield(q, narrowed<flows>(d.materials[q.object]), dt);
    asm volatile("" ::: "memory");  // so that what was there is read again, not kept in registers
    happened.repaired = repair(q, particles.load(i));
    happened.speed_squared = dot(q.v, q.v);
    particles.store(i, q);
    return happened;
}

// What happened in the thread block, on its way to the frame's counters.
struct Sums {
    unsigned yielded, projected, confined, repaired, covered, deepest, fastest;
};

template <bool tools>
__device__ void count(Sums& sums, const Events& e)
{
    const bool first = (threadIdx.x & 31) == 0;
    const auto total = [&](unsigned& to, bool happened) {
        const unsigned lanes = __ballot_sync(all_lanes, happened);
        if (first && lanes) atomicAdd(&to, unsigned(__popc(lanes)));
    };
    const auto largest = [&](unsigned& to, float value) {  // of numbers >= 0: as their bits
        const unsigned bits = __reduce_max_sync(all_lanes, __float_as_uint(value));
        if (first && bits) atomicMax(&to, bits);
    };
    total(sums.yielded, e.yielded), total(sums.confined, e.confined);
    total(sums.repaired, e.repaired), largest(sums.fastest, e.speed_squared);
    if constexpr (tools) total(sums.covered, e.covered);
    if constexpr (tools) total(sums.projected, e.projected), largest(sums.deepest, e.depth);
}

// Blocks per multiprocessor: as many as leave registers enough to spill nothing.
template <bool tools, Flows flows>
constexpr int resident = flows == Flows::any&& tools ? 3 : 5;

template <bool tools, Flows flows, bool blades>
__global__ void __launch_bounds__(threads, resident<tools, flows>)
    g2p_kernel(const __grid_constant__ Views d)
{
    __shared__ Sums sums;
    if (threadIdx.x == 0) sums = {};
    __syncthreads();
    const int i = int(blockIdx.x * threads + threadIdx.x);
    const ParticleView& particles = d.particles[d.clock->side];
    Events happened{};
    if (i < particles.count) happened = moved<tools, flows, blades>(d, particles, i);
    count<tools>(sums, happened);
    __syncthreads();
    if (threadIdx.x != 0) return;
    Counters& n = d.clock->counters;
    const auto add = [](unsigned long long& to, unsigned some) {
        if (some) atomicAdd(&to, static_cast<unsigned long long>(some));
    };
    add(n.yielded, sums.yielded), add(n.projected, sums.projected);
    add(n.confined, sums.confined), add(n.repaired, sums.repaired);
    add(n.covered, sums.covered);
    if (sums.deepest) atomicMax(&n.deepest, sums.deepest);
    atomicMax(&d.clock->fastest, sums.fastest);
    __threadfence();
    if (atomicAdd(&d.clock->finished, 1u) == gridDim.x - 1) finish(d);
}

template <bool tools>
auto kernel_for(Flows flows)
{
    return flows == Flows::elastic   ? g2p_kernel<tools, Flows::elastic, false>
           : flows == Flows::plastic ? g2p_kernel<tools, Flows::plastic, false>
                                     : g2p_kernel<tools, Flows::any, false>;
}

}  // namespace

void begin(const Views& views, cudaStream_t stream)
{
    launch("begin", begin_kernel, 1, 1, stream, views);
}

void g2p(const Views& views, const Needs& needs, cudaStream_t stream)
{
    launch("g2p",
           needs.blades  ? g2p_kernel<true, Flows::any, true>
           : needs.tools ? kernel_for<true>(needs.flows)
                         : kernel_for<false>(needs.flows),
           blocks_for(views.particles[0].count, threads), threads, stream, views);
}

}  // namespace knead::gpu
