// Tools for one substep: joints between the frame's ends, spheres hung on them, shapes derived from
// the spheres.
#pragma once
#include "cuda/contact/skinning.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// The work is shared by so many thread blocks, each of which poses the spheres that its primitives
// need: spheres of two parts are posed twice, to the same bits.
constexpr int pose_parts = 8, part_primitives = max_primitives / pose_parts;

// Index of the k-th primitive of a part.
__device__ inline int primitive_of(int part, int k) { return part + k * pose_parts; }

// Of so many joints each is interpolated once for all spheres; of more, once for each sphere.
constexpr int staged_joints = 64;

struct PoseSpace {
    Joint<float> from[staged_joints], to[staged_joints];
    Sphere<float> spheres[3 * part_primitives];
};

__device__ inline Joint<float> joint_at(const RigView& t, double share, int j)
{
    return cast<float>(between(t.from[j], t.to[j], share));
}

// Called by all threads of a block; poses for substep n. Kept out of line: its registers are not
// those of the kernels that it shares a launch with.
static __device__ __noinline__ void pose_part(const PoseView& t, PoseSpace& s, int part, int n)
{
    const Step& step = t.clock->step(n);
    const double duration = t.clock->duration, dt = step.dt;
    const double from = step.start / duration, to = (step.start + dt) / duration;
    const int thread = int(threadIdx.x), threads = int(blockDim.x), parity = n & 1;
    const bool staged = t.joints <= staged_joints;
    for (int k = thread; staged && k < 2 * t.joints; k += threads)
        (k & 1 ? s.to : s.from)[k >> 1] = joint_at(t, k & 1 ? to : from, k >> 1);
    __syncthreads();
    const auto at = [&](const Joint<float>* stage, double share) {
        return [=, &t](int j) { return staged ? stage[j] : joint_at(t, share, j); };
    };
    const int count = t.primitives.count;
    for (int k = thread; k < 3 * part_primitives; k += threads) {
        if (primitive_of(part, k / 3) >= count) break;
        const int i = t.primitives[primitive_of(part, k / 3)].sphere[k % 3];
        s.spheres[k] = posed(t.bindings[i], at(s.from, from), at(s.to, to), float(dt));
        t.spheres[parity][i] = s.spheres[k];
    }
    __syncthreads();
    for (int k = thread; k < part_primitives && primitive_of(part, k) < count; k += threads) {
        const Sphere<float>* own = s.spheres + 3 * k;
        form(t.shapes[parity][primitive_of(part, k)], t.primitives[primitive_of(part, k)].count,
             own[0], own[1], own[2]);
    }
}

}  // namespace knead::gpu
