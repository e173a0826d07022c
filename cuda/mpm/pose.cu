// Tools before a frame's first substep: for every block of the lattice the primitives that can
// touch its contents during the frame, and the first pose.
#include "cuda/contact/cut.h"
#include "cuda/contact/sweep.h"
#include "cuda/device/launch.cuh"
#include "cuda/mpm/g2p.h"
#include "cuda/mpm/pose.cuh"
#include "cuda/mpm/stages.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

__global__ void __launch_bounds__(threads) pose_kernel(const __grid_constant__ PoseView d)
{
    __shared__ PoseSpace space;
    take_view(d, space);
    pose_part(space, int(blockIdx.x), d.clock->done);
}

// Space swept by the tools during the frame, split like posing. A thread has a joint at one of
// three times, and a sphere; the sphere's binding is loaded before the joints.
constexpr int sweep_threads = 3 * staged_joints;
static_assert(3 * part_primitives <= sweep_threads);
__global__ void __launch_bounds__(sweep_threads) sweep_kernel(const __grid_constant__ SweepView t)
{
    __shared__ Joint<float> joints[3][staged_joints];  // at start, middle, end of frame
    __shared__ Sphere<float> spheres[3 * part_primitives];
    __shared__ float travel[3 * part_primitives];
    // Per thread: an array with a run-time index would be in local memory.
    __shared__ Binding<float> bindings[3 * part_primitives];
    const int part = int(blockIdx.x), thread = int(threadIdx.x), count = t.primitives.count;
    const bool staged = t.joints <= staged_joints;
    const bool posing = thread < 3 * part_primitives && primitive_of(part, thread / 3) < count;
    Stretch<float> size{};
    if (posing) {
        const Primitive& p = t.primitives[primitive_of(part, thread / 3)];
        bindings[thread] = t.bindings[p.sphere[thread % 3]], size = t.tools[p.tool].stretch;
    }
    if (staged && thread < 3 * t.joints) {
        const int end = thread / t.joints, j = thread % t.joints;
        joints[end][j] = joint_at(t, 0.5 * end, j);
    }
    __syncthreads();
    const auto at = [&](int end) {
        return [&t, staged, end, pose = joints[end]](int j) {
            return staged ? pose[j] : joint_at(t, 0.5 * end, j);
        };
    };
    if (posing) {
        travel[thread] = 0;
        spheres[thread] = mid_frame(bindings[thread], size, at(0), at(1), at(2), travel[thread]);
    }
    __syncthreads();
    if (thread >= part_primitives || primitive_of(part, thread) >= count) return;
    const int i = primitive_of(part, thread);
    const Sphere<float>* own = spheres + 3 * thread;
    form(t.mid_frame[i], t.primitives[i].count, own[0], own[1], own[2]);
    t.travel[i] = max(travel[3 * thread], max(travel[3 * thread + 1], travel[3 * thread + 2]));
}

// The primitives of a lane, one per word of a mask, one bit each: those of active tools, and of
// blades.
struct OwnPrimitives {
    unsigned active, blades;
};
__device__ OwnPrimitives own_primitives(const SweptView& t, int lane)
{
    OwnPrimitives own{};
    UNROLL
    for (int word = 0; word < mask_words; ++word) {
        const int i = 32 * word + lane;
        if (i >= t.primitives.count) continue;
        const Tool<float>& tool = t.tools[t.primitives[i].tool];
        own.active |= unsigned(tool.active) << word, own.blades |= unsigned(tool.blade) << word;
    }
    return own;
}

// Whether primitive i may touch anything in the cube with centre p.
__device__ bool may_touch(const SweptView& t, int i, bool blade, Vec3<float> p, float edge,
                          float dx)
{
    const float band = candidate_band(blade) * dx + t.travel[i], half = 0.5f * edge + band;
    const Shape<float>& s = t.mid_frame[i];
    const bool beside = p.x + half < s.low.x || p.x - half > s.high.x || p.y + half < s.low.y ||
                        p.y - half > s.high.y || p.z + half < s.low.z || p.z - half > s.high.z;
    return !beside && reaches(s, p, edge, band);
}

// One warp per block of the lattice, one lane per primitive.
__global__ void __launch_bounds__(threads) mask_kernel(const __grid_constant__ MaskView d)
{
    const int thread = int(blockIdx.x * threads + threadIdx.x), lane = thread & 31;
    const OwnPrimitives own = own_primitives(d, lane);
    const int b = thread / 32;
    if (b >= d.lattice.block_count()) return;
    const Int3 at = d.lattice.block_at(b);
    const float edge = block_edge * d.lattice.dx;
    const Vec3<float> p = {edge * (float(at.x) + 0.5f), edge * (float(at.y) + 0.5f),
                           edge * (float(at.z) + 0.5f)};
    ROLLED
    for (int word = 0; word < mask_words; ++word) {
        const bool touches =
            (own.active >> word & 1) &&
            may_touch(d, 32 * word + lane, own.blades >> word & 1, p, edge, d.lattice.dx);
        const unsigned bits = __ballot_sync(0xffffffffu, touches);
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

__global__ void __launch_bounds__(threads, 4)
    velocity_kernel(const __grid_constant__ VelocityView d)
{
    const int i = int(blockIdx.x * threads + threadIdx.x), side = d.clock->side;
    const ParticleView& particles = d.particles[side];
    if (i >= particles.count) return;
    const int last = d.clock->done - 1;
    const Particle<float> q = particles.load(i);
    const int b = d.lattice.block_of(d.lattice.cell_of(q.x));
    const auto node = [&](Int3 n) {
        const float4 at = d.nodes[last & 1][d.lattice.index(n)];
        return Node<float>{{at.x, at.y, at.z}, at.w};
    };
    Vec3<float> v = q.v;
    if (deepest_contact(d.contact.colliders(last), d.masks[b], q.x, d.skin).phi < 0)
        v = velocity_at(q.x, d.lattice.spacing, q.v, node);
    free_row(d.particles, side)[particles.ids[i]] = {v.x, v.y, v.z, 0};
}

}  // namespace

void masks(const Views& views, cudaStream_t stream)
{
    launch("sweep", sweep_kernel, pose_parts, sweep_threads, stream, sweep_view(views));
    launch("masks", mask_kernel, blocks_for(views.lattice.block_count(), threads / 32), threads,
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

void velocities(const Views& views, cudaStream_t stream)
{
    launch("velocities", velocity_kernel, blocks_for(views.particles[0].count, threads), threads,
           stream, velocity_view(views));
}

}  // namespace knead::gpu
