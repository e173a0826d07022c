// Tools for one substep: joints between the frame's ends, spheres hung on them, shapes derived from
// the spheres, and for every block of the lattice the primitives that can touch what is in it.
#include "blade.h"
#include "launch.cuh"
#include "stages.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

__global__ void __launch_bounds__(threads) pose_kernel(const __grid_constant__ Views d)
{
    const Clock& clock = *d.clock;
    const double from = clock.elapsed / clock.duration,
                 to = (clock.elapsed + clock.dt) / clock.duration;
    const auto at = [&](double share) {
        return [&d, share](int j) {
            const Joint<double> b = between(d.tools.from[j], d.tools.to[j], share);
            return Joint<float>{cast<float>(b.q), cast<float>(b.p)};
        };
    };
    const Span<Sphere<float>> spheres = d.tools.spheres;
    for (int i = int(threadIdx.x); i < spheres.count; i += threads)
        spheres[i] = posed(d.tools.bindings[i], at(from), at(to), float(clock.dt));
    __syncthreads();
    for (int i = int(threadIdx.x); i < d.tools.shapes.count; i += threads) {
        const Primitive& p = d.tools.primitives[i];
        d.tools.shapes[i] =
            shape(p.count, spheres[p.sphere[0]], spheres[p.sphere[1]], spheres[p.sphere[2]]);
    }
}

// Whether primitive i may touch what is in the cube of centre p.
__device__ bool may_touch(const ToolView& t, int i, Vec3<float> p, float edge, float dx)
{
    if (i >= t.primitives.count) return false;
    const Tool<float>& tool = t.tools[t.primitives[i].tool];
    if (!tool.active) return false;
    const float band = candidate_band(tool.blade) * dx, half = 0.5f * edge + band;
    const Shape<float>& s = t.shapes[i];
    const bool beside = p.x + half < s.low.x || p.x - half > s.high.x || p.y + half < s.low.y ||
                        p.y - half > s.high.y || p.z + half < s.low.z || p.z - half > s.high.z;
    return !beside && reaches(s, p, edge, band);
}

// One warp per block of the lattice, one lane per primitive.
__global__ void __launch_bounds__(threads) mask_kernel(const __grid_constant__ Views d)
{
    const int b = int(blockIdx.x * threads + threadIdx.x) / 32, lane = int(threadIdx.x & 31);
    if (b >= d.lattice.block_count()) return;
    const Int3 at = d.lattice.block_at(b);
    const float edge = block_edge * d.lattice.dx;
    const Vec3<float> p = {edge * (float(at.x) + 0.5f), edge * (float(at.y) + 0.5f),
                           edge * (float(at.z) + 0.5f)};
    for (int word = 0; word < mask_words; ++word) {
        const unsigned bits =
            __ballot_sync(0xffffffffu, may_touch(d.tools, 32 * word + lane, p, edge, d.lattice.dx));
        if (lane == 0) d.tools.masks[b].bits[word] = bits;
    }
}

__global__ void __launch_bounds__(threads)
    penetration_kernel(const __grid_constant__ Views d, float* depth)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    const ParticleView& particles = d.particles[d.clock->side];
    if (i >= particles.count) return;
    const Vec3<float> x = particles.position(i);
    const float dx = d.lattice.dx;
    const int b = d.lattice.block_of({int(x.x / dx), int(x.y / dx), int(x.z / dx)});
    depth[particles.ids[i]] = most(-nearest(d.tools.colliders(), d.tools.masks[b], x).phi, 0.0f);
}

}  // namespace

void pose(const Views& views, cudaStream_t stream)
{
    launch("pose", pose_kernel, 1, threads, stream, views);
    launch("masks", mask_kernel, blocks_for(views.lattice.block_count(), threads / 32), threads,
           stream, views);
}

void penetration(const Views& views, float* depth, cudaStream_t stream)
{
    launch("penetration", penetration_kernel, blocks_for(views.particles[0].count, threads),
           threads, stream, views, depth);
}

}  // namespace knead::gpu
