// Particle to grid: the scatter that a frame begins with. All others are done by the kernel that
// moves the particles, g2p.cu.
#include "cuda/mpm/project.cuh"
#include "cuda/mpm/scatter.cuh"

namespace knead::gpu {
namespace {

// Those runs of particles that look for contact take longest, so they come first: started last,
// they would keep all others waiting. By all threads of a block.
__device__ void line_up(const P2gView& d, int run, bool near)
{
    if (!__syncthreads_or(near)) {
        if (threadIdx.x == 0) d.runs[int(gridDim.x) - 1 - atomicAdd(&d.clock->far_runs, 1)] = run;
    } else if (threadIdx.x == 0) {
        d.runs[atomicAdd(&d.clock->near_runs, 1)] = run;
    }
}

template <bool any, bool blades, bool rests>
__global__ void __launch_bounds__(scatter_threads<blades>, 4)
    p2g_kernel(const __grid_constant__ P2gView d)
{
    __shared__ ScatterSpace<blades> space;
    Clock& clock = *d.clock;
    const ConstParticleView& particles = d.particles[clock.side];
    const int n = clock.done;
    if (!(clock.step(n).dt > 0)) return;
    for_each_run<rests>(clock, d.listed, 0, int(blockIdx.x), [&](int run) {
        const int i = run * scatter_threads<blades> + int(threadIdx.x);
        const bool valid = i < particles.count;
        const Particle<float> q = particles.load(valid ? i : particles.count - 1);
        if (!rests && d.runs) line_up(d, run, near_tools(d.near, d.lattice, q.x) != nullptr);
        Material<float> m = d.materials[q.object];
        if constexpr (!any) m.elasticity = Elasticity::neo_hookean, m.plasticity = Plasticity::none;
        WarpScatter<blades, true>{d, space, n}(q, m, valid, float(clock.step(n).dt));
    });
}

template <bool rests>
auto kernel_for(const Features& features)
{
    return features.blades                               ? p2g_kernel<true, true, rests>
           : features.plasticity == PlasticityClass::any ? p2g_kernel<true, false, rests>
                                                         : p2g_kernel<false, false, rests>;
}

}  // namespace

void p2g(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream)
{
    const auto kernel = features.rests ? kernel_for<true>(features) : kernel_for<false>(features);
    launch("p2g", kernel, blocks_for_runs(views, features, multiprocessors), run_length(features),
           stream, p2g_view(views));
}

}  // namespace knead::gpu
