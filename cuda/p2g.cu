// Particle to grid: the scatter that a frame begins with. All others are done by the kernel that
// moves the particles, g2p.cu.
#include "launch.cuh"
#include "scatter.cuh"

namespace knead::gpu {
namespace {

template <bool any, bool blades>
__global__ void __launch_bounds__(scatter_threads<blades>)
    p2g_kernel(const __grid_constant__ Views d)
{
    __shared__ ScatterSpace<blades> space;
    Clock& clock = *d.clock;
    const int i = int(blockIdx.x * scatter_threads<blades> + threadIdx.x);
    const ParticleView& particles = d.particles[clock.side];
    const bool valid = i < particles.count;
    const Particle<float> q = particles.load(valid ? i : particles.count - 1);
    Material<float> m = d.materials[q.object];
    if constexpr (!any) m.elasticity = Elasticity::neo_hookean, m.flow = Flow::none;
    const int n = clock.done;
    WarpScatter<blades>{d, space, n}(q, m, valid, float(clock.step(n).dt));
    __syncthreads();
    flush<blades>(d, space, n);
}

}  // namespace

void p2g(const Views& views, const Needs& needs, cudaStream_t stream)
{
    const int count = views.particles[0].count;
    if (needs.blades)
        launch("p2g", p2g_kernel<true, true>, blocks_for(count, scatter_threads<true>),
               scatter_threads<true>, stream, views);
    else
        launch("p2g",
               needs.flows == Flows::any ? p2g_kernel<true, false> : p2g_kernel<false, false>,
               blocks_for(count, scatter_threads<false>), scatter_threads<false>, stream, views);
}

}  // namespace knead::gpu
