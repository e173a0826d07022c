// Particle to grid, one thread per particle. Neighbours in the sort share their 27 nodes: the lanes
// of a warp that do are summed by shuffles, and only the first of them touches the grid. Runs are
// found from where the particles are now, so drift since the sort costs speed, never correctness.
#include <nv/target>

#include "blade.h"
#include "launch.cuh"
#include "p2g.h"
#include "stages.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;
constexpr int merge_levels = 3;  // runs are cut after 2^levels lanes; 8 particles fill a cell
constexpr unsigned all_lanes = 0xffffffffu;

// A run of lanes that share their nodes.
struct Run {
    bool head;                  // this lane adds for the run
    bool joined[merge_levels];  // the lane 2^k further on is of the same run
};

__device__ Run run_of(int key, bool valid)
{
    constexpr int most_lanes = 1 << merge_levels;
    const int lane = int(threadIdx.x & 31);
    const int before = __shfl_up_sync(all_lanes, key, 1);
    const unsigned starts = __ballot_sync(all_lanes, lane == 0 || key != before);
    const unsigned up_to_here = (2u << lane) - 1;  // 2 << 31 is 0: all lanes
    const int start = 31 - __clz(int(starts & up_to_here));
    const unsigned later = starts & ~up_to_here;
    const int next = later ? __ffs(int(later)) - 1 : 32;
    const int place = (lane - start) % most_lanes;
    const int end = least(next, lane - place + most_lanes);
    Run run{valid && place == 0, {}};
    UNROLL
    for (int k = 0; k < merge_levels; ++k) run.joined[k] = lane + (1 << k) < end;
    return run;
}

__device__ float summed(const Run& run, float value)
{
    UNROLL
    for (int k = 0; k < merge_levels; ++k) {
        const float other = __shfl_down_sync(all_lanes, value, 1u << k);
        if (run.joined[k]) value += other;
    }
    return value;
}

// Adds n to *to if `here`. Predicated, not branched, on sm_90: a branch would part the lanes of the
// warp before the next shuffle, and make the compiler gather them again at each.
__device__ void add(float4* to, const Node<float>& n, bool here)
{
    NV_IF_ELSE_TARGET(
        NV_PROVIDES_SM_90,
        (asm volatile("{ .reg .pred p; setp.ne.s32 p, %0, 0;"
                      " @p red.global.add.v4.f32 [%1], {%2, %3, %4, %5}; }" ::"r"(int(here)),
                      "l"(__cvta_generic_to_global(to)), "f"(n.p.x), "f"(n.p.y), "f"(n.p.z),
                      "f"(n.m)
                      : "memory");),
        (if (here) {
            atomicAdd(&to->x, n.p.x);
            atomicAdd(&to->y, n.p.y);
            atomicAdd(&to->z, n.p.z);
            atomicAdd(&to->w, n.m);
        }))
}

// Integers add up to the same bits in any order.
__device__ void add(long long* to, const Node<float>& n, float momentum_scale, float mass_scale)
{
    const auto one = [](long long* at, float value) {
        atomicAdd(reinterpret_cast<unsigned long long*>(at),
                  static_cast<unsigned long long>(__float2ll_rn(value)));
    };
    one(to + 0, momentum_scale * n.p.x);
    one(to + 1, momentum_scale * n.p.y);
    one(to + 2, momentum_scale * n.p.z);
    one(to + 3, mass_scale * n.m);
}

// Lists the up to eight blocks that the nodes from `base` lie in.
__device__ void touch(const GridView& grid, Clock* clock, int parity, const Lattice<float>& lattice,
                      Int3 base)
{
    const Int3 reach = {(base.x & 3) > 1, (base.y & 3) > 1, (base.z & 3) > 1};
    for (int z = 0; z <= reach.z; ++z)
        for (int y = 0; y <= reach.y; ++y)
            for (int x = 0; x <= reach.x; ++x) {
                const int b = lattice.block_of(base + 4 * Int3{x, y, z});
                unsigned* mark = grid.touched[parity] + b;
                if (__ldcg(mark) || atomicExch(mark, 1u)) continue;
                grid.list[parity][atomicAdd(&clock->active[parity], 1)] = b;
            }
}

template <bool any, bool fixed_point, bool blades>
__global__ void __launch_bounds__(threads, blades ? 4 : 6)
    p2g_kernel(const __grid_constant__ Views d)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    const int parity = d.clock->parity;
    const ParticleView& particles = d.particles[d.clock->side];
    const bool valid = i < particles.count;
    const Particle<float> q = particles.load(valid ? i : particles.count - 1);
    Material<float> m = d.materials[q.object];
    if constexpr (!any) m.elasticity = Elasticity::neo_hookean, m.flow = Flow::none;
    const float dt = float(d.clock->dt);
    const Stencil<float> s = stencil(q.x, d.lattice.dx);
    const Offsets o = offsets(d.lattice, s.base);
    const Run run = run_of(valid ? o.at({0, 0, 0}) : -1, valid);
    if (run.head) touch(d.grid, d.clock, parity, d.lattice, s.base);
    __syncwarp();
    float4* nodes = d.grid.nodes[parity];
    long long* sums = d.grid.sums[parity];
    const auto hand_out = [&](int node, const Node<float>& share, bool here) {
        if constexpr (fixed_point) {
            if (valid && here)
                add(sums + 4 * std::size_t(node), share, d.grid.momentum_scale, d.grid.mass_scale);
        } else {
            const auto part = [&](float s) { return summed(run, here ? s : 0.0f); };
            const Node<float> sum{{part(share.p.x), part(share.p.y), part(share.p.z)},
                                  part(share.m)};
            add(nodes + node, sum, run.head);
        }
    };
    scatter(q, m, s, d.lattice.dx, dt, [&](Int3 step, const Node<float>& share) {
        const int node = o.at(step);
        hand_out(node, share, true);
        if constexpr (blades) {
            const int count = d.lattice.node_count();
            hand_out(count + node, share, q.sides != below);
            hand_out(2 * count + node, share, q.sides != above);
        }
    });
}

}  // namespace

void p2g(const Views& views, const Needs& needs, cudaStream_t stream)
{
    const bool any = needs.flows == Flows::any;
    if (needs.blades) {
        launch("p2g",
               needs.fixed_point ? p2g_kernel<true, true, true> : p2g_kernel<true, false, true>,
               blocks_for(views.particles[0].count, threads), threads, stream, views);
        return;
    }
    const auto kernel =
        needs.fixed_point
            ? (any ? p2g_kernel<true, true, false> : p2g_kernel<false, true, false>)
            : (any ? p2g_kernel<true, false, false> : p2g_kernel<false, false, false>);
    launch("p2g", kernel, blocks_for(views.particles[0].count, threads), threads, stream, views);
}

}  // namespace knead::gpu
