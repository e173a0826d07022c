// Particle to grid: the first scatter of a frame. All others are part of g2p.cu.
#include "cuda/device/launch.cuh"
#include "cuda/mpm/scatter.cuh"
#include "cuda/mpm/stages.cuh"
#include "cuda/mpm/substep.cuh"
#include "cuda/mpm/yield.cuh"

namespace knead::gpu {
namespace {

constexpr Features relevant(Features f)
{
    const bool any = f.plasticity == PlasticityClass::any;
    return {.blades = f.blades,
            .rests = f.rests,
            .plasticity = any || f.bodies ? PlasticityClass::any : PlasticityClass::elastic,
            .bodies = f.bodies};
}

template <class Case>
__global__ void __launch_bounds__(run_length(Case::features), 4)
    p2g_kernel(const __grid_constant__ P2gView d)
{
    constexpr Features f = Case::features;
    __shared__ WarpScratch<shares_fields(f)> scratch;
    Clock& clock = *d.clock;
    const ConstParticleView& particles = d.particles[clock.side];
    const int n = clock.done;
    if (!(clock.step(n).dt > 0)) return;
    for_each_run<f.rests>(clock, d.listed, 0, int(blockIdx.x), [&](int run) {
        const int i = run * run_length(f) + int(threadIdx.x);
        const bool valid = i < particles.count;
        Particle<float> q = particles.load(valid ? i : particles.count - 1);
        Material<float> m = narrowed<f.plasticity>(d.materials[q.object]);
        const float dt = float(clock.step(n).dt);
        if (f.rests && stands(d.mode, q)) q.v = held_rise(d.gravity, dt), m = as_held(m);
        const int field = field_of<f>(d.materials, q);
        WarpScatter<shares_fields(f), true, f.bodies>{d, scratch, n, clock.relisted}(
            q, m, 1 / m.mass, valid, dt, field);
    });
}

}  // namespace

void p2g(const Views& views, const Features& features, int multiprocessors, cudaStream_t stream)
{
    const auto kernel =
        dispatch<relevant>(features, []<class Case>(Case) { return p2g_kernel<Case>; });
    launch("p2g", kernel, blocks_for_runs(views.particles[0].count, features, multiprocessors),
           run_length(features), stream, p2g_view(views));
}

}  // namespace knead::gpu
