// Cell-averaged pressure: sums of a frame's first substep, and clearing for the next one. All other
// sums are part of g2p.cu.
#include "cuda/mpm/mean_pressure.cuh"
#include "cuda/mpm/stages.cuh"
#include "cuda/mpm/substep_sync.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

__global__ void __launch_bounds__(threads) find_kernel(const __grid_constant__ PressureFindView d)
{
    const ConstParticleView& particles = d.particles[d.clock->side];
    const int i = int(blockIdx.x * blockDim.x + threadIdx.x);
    if (i >= particles.count) return;
    const Particle<float> q = particles.load_state(i);
    add_pressure(d, d.lattice, q, d.materials[q.object], d.clock->done);
}

// Clears the sums for substep n + 1 in the blocks listed for substep n; other blocks hold no sums.
__global__ void __launch_bounds__(block_nodes)
    clear_kernel(const __grid_constant__ PressureClearView d)
{
    let_next_stage_start();
    const int n = d.clock->begun, listed = d.clock->active[n % 3];
    for (int k = int(blockIdx.x); k < listed; k += int(gridDim.x))
        d.cells[(n + 1) & 1][block_of(d.list[n % 3][k]) * block_nodes + int(threadIdx.x)] = {};
}

}  // namespace

void find_pressures(const Views& views, cudaStream_t stream)
{
    const std::size_t bytes = std::size_t(views.lattice.node_count()) * sizeof(CellPressure);
    for (CellPressure* cells : views.pressure.cells)
        check(cudaMemsetAsync(cells, 0, bytes, stream), "pressures");
    launch("pressures", find_kernel, blocks_for(views.particles[0].count, threads), threads, stream,
           pressure_find_view(views));
}

void clear_pressures(const Views& views, int multiprocessors, cudaStream_t stream)
{
    launch("clear pressures", clear_kernel, 8 * multiprocessors, block_nodes, stream,
           pressure_clear_view(views));
}

}  // namespace knead::gpu
