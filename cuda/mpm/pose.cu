// What a frame needs of its tools before the first substep: for every block of the lattice the
// primitives that can touch what is in it at any time of the frame, and the first pose.
#include "cuda/contact/cut.h"
#include "cuda/contact/sweep.h"
#include "cuda/device/launch.cuh"
#include "cuda/mpm/pose.cuh"
#include "cuda/mpm/stages.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

__global__ void __launch_bounds__(threads) pose_kernel(const __grid_constant__ PoseView d)
{
    __shared__ PoseSpace space;
    take_view(d, space);
    pose_part(space, int(blockIdx.x), false);
}

// Where the tools may be at any time of the frame, shared out as posing is.
__global__ void __launch_bounds__(threads) sweep_kernel(const __grid_constant__ SweepView t)
{
    __shared__ Joint<float> joints[3][staged_joints];  // at the frame's beginning, middle and end
    __shared__ Sphere<float> spheres[3 * part_primitives];
    __shared__ float travel[3 * part_primitives];
    trigger_dependents();
    const int part = int(blockIdx.x), thread = int(threadIdx.x), count = t.primitives.count;
    const bool staged = t.joints <= staged_joints;
    for (int k = thread; staged && k < 3 * t.joints; k += threads)
        joints[k / t.joints][k % t.joints] = joint_at(t, 0.5 * (k / t.joints), k % t.joints);
    __syncthreads();
    const auto at = [&](int end) {
        return [&t, staged, end, pose = joints[end]](int j) {
            return staged ? pose[j] : joint_at(t, 0.5 * end, j);
        };
    };
    for (int k = thread; k < 3 * part_primitives && primitive_of(part, k / 3) < count;
         k += threads) {
        const Primitive& p = t.primitives[primitive_of(part, k / 3)];
        spheres[k] = amid(t.bindings[p.sphere[k % 3]], t.tools[p.tool].stretch, at(0), at(1), at(2),
                          travel[k] = 0);
    }
    __syncthreads();
    for (int k = thread; k < part_primitives && primitive_of(part, k) < count; k += threads) {
        const int i = primitive_of(part, k);
        const Sphere<float>* own = spheres + 3 * k;
        form(t.amid[i], t.primitives[i].count, own[0], own[1], own[2]);
        t.travel[i] = max(travel[3 * k], max(travel[3 * k + 1], travel[3 * k + 2]));
    }
}

// Whether primitive i may touch what is in the cube of centre p.
__device__ bool may_touch(const SweptView& t, int i, Vec3<float> p, float edge, float dx)
{
    if (i >= t.primitives.count) return false;
    const Tool<float>& tool = t.tools[t.primitives[i].tool];
    if (!tool.active) return false;
    const float band = candidate_band(tool.blade) * dx + t.travel[i], half = 0.5f * edge + band;
    const Shape<float>& s = t.amid[i];
    const bool beside = p.x + half < s.low.x || p.x - half > s.high.x || p.y + half < s.low.y ||
                        p.y - half > s.high.y || p.z + half < s.low.z || p.z - half > s.high.z;
    return !beside && reaches(s, p, edge, band);
}

// One warp per block of the lattice, one lane per primitive. And the frame before is over, so the
// runs of particles that it has lined up take their places.
__global__ void __launch_bounds__(threads) mask_kernel(const __grid_constant__ MaskView d)
{
    wait_for_upstream();
    const int thread = int(blockIdx.x * threads + threadIdx.x);
    for (int k = thread; k < d.run_count; k += int(gridDim.x) * threads) d.runs[k] = d.next_runs[k];
    const int b = thread / 32, lane = int(threadIdx.x & 31);
    if (b >= d.lattice.block_count()) return;
    const Int3 at = d.lattice.block_at(b);
    const float edge = block_edge * d.lattice.dx;
    const Vec3<float> p = {edge * (float(at.x) + 0.5f), edge * (float(at.y) + 0.5f),
                           edge * (float(at.z) + 0.5f)};
    for (int word = 0; word < mask_words; ++word) {
        const unsigned bits =
            __ballot_sync(0xffffffffu, may_touch(d, 32 * word + lane, p, edge, d.lattice.dx));
        if (lane == 0) d.masks[b].bits[word] = bits;
    }
}

__global__ void __launch_bounds__(threads, 8)
    penetration_kernel(const __grid_constant__ PenetrationView d)
{
    const int i = int(blockIdx.x * threads + threadIdx.x), side = d.clock->side;
    const ParticleView& particles = d.particles[side];
    if (i >= particles.count) return;
    float* depth = reinterpret_cast<float*>(free_row(d.particles, side));
    const Vec3<float> x = particles.position(i);
    const int b = d.lattice.block_of(d.lattice.cell_of(x));
    const Colliders<float> last = d.contact.colliders(d.clock->done - 1);
    depth[particles.ids[i]] = max(-deepest_contact(last, d.masks[b], x).phi, 0.0f);
}

}  // namespace

void masks(const Views& views, cudaStream_t stream)
{
    launch("sweep", sweep_kernel, pose_parts, threads, stream, sweep_view(views));
    launch_pdl("masks", mask_kernel, blocks_for(views.lattice.block_count(), threads / 32), threads,
               stream, mask_view(views));
}

void pose(const Views& views, cudaStream_t stream)
{
    launch("pose", pose_kernel, pose_parts, threads, stream, pose_view(views));
}

void penetration(const Views& views, cudaStream_t stream)
{
    launch("penetration", penetration_kernel, blocks_for(views.particles[0].count, threads),
           threads, stream, penetration_view(views));
}

}  // namespace knead::gpu
