// Grid update: one thread block per listed block of nodes, as many as there are, however many the
// launch brings. The grid of the substep before is cleared on the way, and a block of its own looks
// after the clock.
#include "blade.h"
#include "grid.h"
#include "launch.cuh"
#include "stages.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = block_nodes;

template <bool fixed_point>
__device__ Node<float> sum_of(const GridView& grid, int parity, int i)
{
    if constexpr (fixed_point) {
        const longlong2* at =
            reinterpret_cast<const longlong2*>(grid.sums[parity] + 4 * std::size_t(i));
        const longlong2 a = at[0], b = at[1];
        const double p = 1 / double(grid.momentum_scale), m = 1 / double(grid.mass_scale);
        return {{float(p * double(a.x)), float(p * double(a.y)), float(p * double(b.x))},
                float(m * double(b.y))};
    } else {
        const float4 n = grid.nodes[parity][i];
        return {{n.x, n.y, n.z}, n.w};
    }
}

template <bool fixed_point>
__device__ void clear(const GridView& grid, int parity, int i)
{
    if constexpr (fixed_point) {
        longlong2* at = reinterpret_cast<longlong2*>(grid.sums[parity] + 4 * std::size_t(i));
        at[0] = at[1] = longlong2{0, 0};
    } else {
        grid.nodes[parity][i] = {0, 0, 0, 0};
    }
}

// Counts substep n, and chooses the one after it from the speeds that the one before it left.
__device__ void look_ahead(const Views& d, int n)
{
    Clock& c = *d.clock;
    const Step step = c.step(n);
    c.begun = n;
    c.fastest[n & 1] = 0;
    c.woken[n & 1] = 0;
    const double speed = sqrt(double(__uint_as_float(c.fastest[(n + 1) & 1])));
    c.drift += speed * step.dt;
    const Step next = step_after(step, d.pace, speed, c.tool_step, c.duration);
    c.step(n + 1) = next;
    c.dt[0] = float(step.dt), c.dt[1] = float(next.dt);
    if (!(step.dt > 0)) return;
    Counters& all = c.counters;
    all.dt_least = all.substeps ? least(all.dt_least, step.dt) : step.dt;
    all.dt_most = most(all.dt_most, step.dt);
    ++all.substeps;
    ++all.limits[int(step.limit)];
    all.active_blocks = c.active[n % 3];
}

// What the substep before n woke: the neighbours become guards, theirs at least support.
__device__ void stir_neighbours(const Views& d, int n)
{
    const RestView& r = d.rest;
    const int before = (n + 1) & 1, count = d.clock->woken[before];
    const Int3 size = d.lattice.blocks();
    for (int w = int(blockIdx.x) - 1; w < count; w += int(gridDim.x) - 1) {
        const Int3 at = d.lattice.block_at(r.woken[before][w]);
        for (int k = int(threadIdx.x); k < 125; k += threads) {
            const Int3 step = {k % 5 - 2, k / 5 % 5 - 2, k / 25 - 2}, to = at + step;
            if (to.x < 0 || to.y < 0 || to.z < 0 || to.x >= size.x || to.y >= size.y ||
                to.z >= size.z)
                continue;
            const int b = d.lattice.block_of(4 * to);
            if (step.x * step.x <= 1 && step.y * step.y <= 1 && step.z * step.z <= 1)
                atomicMin(&r.guard[b], n + 1);
            if (__ldcg(&r.reached[b]) || atomicExch(&r.reached[b], 1u)) continue;
            const int2 range = r.range[b];
            for (int run = range.x / r.run; run * r.run < range.y; ++run)
                if (!atomicExch(&r.held[run], 1u)) r.list[atomicAdd(&d.clock->listed, 1)] = run;
        }
    }
}

// Calls update(b) for every listed block of nodes, after clearing as many of the other grid.
template <bool fixed_point, class Update>
__device__ void for_each_block(const Views& d, int n, Update&& update)
{
    const int parity = n & 1, first = int(blockIdx.x) - 1, stride = int(gridDim.x) - 1;
    const int count = d.clock->active[n % 3], before = d.clock->active[(n + 2) % 3];
    for (int at = first; at < count || at < before; at += stride) {
        const int b = at < count ? d.grid.list[parity][at] : -1;
        const int old = at < before ? d.grid.list[parity ^ 1][at] : -1;
        if (old >= 0) {
            for (int f = 0; f < d.grid.fields; ++f)
                clear<fixed_point>(
                    d.grid, parity ^ 1,
                    f * d.lattice.node_count() + old * block_nodes + int(threadIdx.x));
            if (threadIdx.x == 0) d.grid.touched[parity ^ 1][old] = 0;
        }
        if (b >= 0) update(b);
    }
}

template <bool tools, bool fixed_point>
__global__ void __launch_bounds__(threads, 12) grid_kernel(const __grid_constant__ Views d)
{
    await_before();
    const int n = d.clock->done, parity = n & 1;
    if (blockIdx.x == 0) {
        if (threadIdx.x == 0) look_ahead(d, n);
        return;
    }
    const float dt = float(d.clock->step(n).dt);
    if (!(dt > 0)) return;
    if (d.rest.rule.mode == RestMode::sleep) stir_neighbours(d, n);
    const Colliders<float> colliders = d.tools.colliders(n);
    for_each_block<fixed_point>(d, n, [&](int b) {
        const int i = b * block_nodes + int(threadIdx.x);
        bool clipped;
        const Node<float> node =
            update(sum_of<fixed_point>(d.grid, parity, i), d.lattice.node_at(i), d.lattice, d.walls,
                   d.gravity, dt, clipped, [&](Vec3<float> x, Vec3<float> v) {
                       if constexpr (tools)
                           if (!empty(d.tools.masks[b]))
                               return held(colliders, d.tools.masks[b], x, v);
                       return v;
                   });
        d.grid.nodes[parity][i] = {node.p.x, node.p.y, node.p.z, node.m};
        if (clipped) atomicAdd(&d.clock->counters.clipped, 1ull);
    });
}

// Which way lies what is below, at node n: along the slope of its mass less that of what is above.
template <bool fixed_point>
__device__ Vec3<float> slope(const Views& d, int parity, Int3 n)
{
    const Int3 size = d.lattice.size;
    const int count = d.lattice.node_count();
    const auto excess = [&](Int3 m) {
        if (m.x < 0 || m.y < 0 || m.z < 0 || m.x >= size.x || m.y >= size.y || m.z >= size.z)
            return 0.0f;
        const int i = d.lattice.index(m);
        return sum_of<fixed_point>(d.grid, parity, below * count + i).m -
               sum_of<fixed_point>(d.grid, parity, above * count + i).m;
    };
    return {excess(n + Int3{1, 0, 0}) - excess(n - Int3{1, 0, 0}),
            excess(n + Int3{0, 1, 0}) - excess(n - Int3{0, 1, 0}),
            excess(n + Int3{0, 0, 1}) - excess(n - Int3{0, 0, 1})};
}

// Where blades are: each label has its own velocity, and the two do not pass through each other.
// Neighbours read masses here, which the update leaves as they are.
template <bool fixed_point>
__global__ void __launch_bounds__(threads, 8) cut_grid_kernel(const __grid_constant__ Views d)
{
    await_before();
    const int n = d.clock->done, parity = n & 1, nodes = d.lattice.node_count();
    if (blockIdx.x == 0) {
        if (threadIdx.x == 0) look_ahead(d, n);
        return;
    }
    const float dt = float(d.clock->step(n).dt), dx = d.lattice.dx;
    if (!(dt > 0)) return;
    if (d.rest.rule.mode == RestMode::sleep) stir_neighbours(d, n);
    const Colliders<float> colliders = d.tools.colliders(n);
    for_each_block<fixed_point>(d, n, [&](int b) {
        const int i = b * block_nodes + int(threadIdx.x);
        const Int3 at = d.lattice.node_at(i);
        const Mask& mask = d.tools.masks[b];
        Node<float> v[3];
        float mass[3];
        UNROLL
        for (int f = 0; f < 3; ++f) {
            const Node<float> sum = sum_of<fixed_point>(d.grid, parity, f * nodes + i);
            mass[f] = sum.m;
            bool clipped;
            v[f] = update(sum, at, d.lattice, d.walls, d.gravity, dt, clipped,
                          [&](Vec3<float> x, Vec3<float> u) {
                              if (!d.tools.grid_contact) return u;
                              u = held(colliders, mask, x, u);
                              return f ? sliced(colliders, mask, x, u, dx, unsigned(f)) : u;
                          });
            if (clipped) atomicAdd(&d.clock->counters.clipped, 1ull);
        }
        divide(v, mass, [&] { return slope<fixed_point>(d, parity, at); });
        UNROLL
        for (int f = 0; f < 3; ++f)
            d.grid.nodes[parity][f * nodes + i] = {v[f].p.x, v[f].p.y, v[f].p.z, v[f].m};
    });
}

}  // namespace

void grid(const Views& views, const Needs& needs, int multiprocessors, cudaStream_t stream)
{
    const int blocks = 1 + least(views.lattice.block_count(), 8 * multiprocessors);
    if (needs.blades) {
        launch_early("grid", needs.fixed_point ? cut_grid_kernel<true> : cut_grid_kernel<false>,
                     blocks, threads, stream, views);
        return;
    }
    const bool tools = needs.tools && views.tools.grid_contact;
    const auto kernel = needs.fixed_point
                            ? (tools ? grid_kernel<true, true> : grid_kernel<false, true>)
                            : (tools ? grid_kernel<true, false> : grid_kernel<false, false>);
    launch_early("grid", kernel, blocks, threads, stream, views);
}

}  // namespace knead::gpu
