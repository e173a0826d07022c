// Poses the tools for one substep: interpolates the joints over the frame, transforms the spheres
// bound to them, and derives shapes from the spheres.
#pragma once
#include "cuda/contact/skinning.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// Posing is split over pose_parts thread blocks, each of which poses the spheres of its primitives:
// spheres of two parts are posed twice, with the same bits.
constexpr int part_primitives = max_primitives / pose_parts;

// Index of the k-th primitive of a part.
__device__ inline int primitive_of(int part, int k) { return part + k * pose_parts; }

// Up to staged_joints joints are each interpolated once for all spheres; if there are more, those
// of staged_spheres spheres at a time, four each.
constexpr int staged_joints = 64, staged_spheres = staged_joints / 4;

struct PoseSpace {
    PoseView view;
    Joint<float> from[staged_joints], to[staged_joints];
    Sphere<float> spheres[3 * part_primitives];
    float sizes[part_primitives];
    float across[part_primitives], along[part_primitives];  // of the tools' stretch
};

__device__ inline Joint<float> joint_at(const RigView& t, double share, int j)
{
    return cast<float>(between(t.from[j], t.to[j], share));
}

// The k-th sphere of a part's primitives, three each; -1: there is none.
__device__ inline int sphere_of(const RigView& t, int part, int k)
{
    const int i = primitive_of(part, k / 3);
    return i < t.primitives.count ? t.primitives[i].sphere[k % 3] : -1;
}

// Poses for substep n. By all threads of a block; precondition: the view is in shared memory. Not
// inlined, so that its registers do not add to those of the calling kernel.
static __device__ __noinline__ void pose_part(PoseSpace& s, int part, int n)
{
    const PoseView& t = s.view;
    const Step& step = t.clock->step(n);
    const double duration = t.clock->duration, dt = step.dt;
    const double from = step.start / duration, to = (step.start + dt) / duration;
    const int thread = int(threadIdx.x), threads = int(blockDim.x), parity = n & 1;
    const bool staged = t.joints <= staged_joints;
    constexpr int count = 3 * part_primitives;
    const int together = staged ? count : staged_spheres;
    // Loaded early: takes two dependent loads, which would delay the spheres.
    for (int k = thread; k < part_primitives && primitive_of(part, k) < t.primitives.count;
         k += threads) {
        const Tool<float>& tool = t.tools[t.primitives[primitive_of(part, k)].tool];
        s.sizes[k] = tool.size;
        s.across[k] = tool.stretch.across, s.along[k] = tool.stretch.along;
    }
    for (int first = 0; first < count; first += together) {
        __syncthreads();  // the previous ones have been read
        for (int k = thread; k < 2 * (staged ? t.joints : staged_joints); k += threads) {
            int j = k >> 1;
            if (!staged) {
                const int i = sphere_of(t, part, first + k / 8);
                if (i < 0) break;
                j = t.bindings[i].joint[k / 2 % 4];
            }
            (k & 1 ? s.to : s.from)[k >> 1] = joint_at(t, k & 1 ? to : from, j);
        }
        __syncthreads();
        for (int k = first + thread; k < first + together; k += threads) {
            const int i = sphere_of(t, part, k);
            if (i < 0) break;
            Binding<float> b = stretched(t.bindings[i], {s.across[k / 3], s.along[k / 3]});
            UNROLL
            for (int m = 0; m < 4; ++m) b.joint[m] = staged ? b.joint[m] : 4 * (k - first) + m;
            s.spheres[k] = posed(
                b, [&s](int j) { return s.from[j]; }, [&s](int j) { return s.to[j]; }, float(dt),
                s.sizes[k / 3]);
            t.spheres[parity][i] = s.spheres[k];
        }
    }
    __syncthreads();
    for (int k = thread; k < part_primitives && primitive_of(part, k) < t.primitives.count;
         k += threads) {
        const int i = primitive_of(part, k);
        const Sphere<float>* own = s.spheres + 3 * k;
        form(t.shapes[parity][i], t.primitives[i].count, own[0], own[1], own[2]);
    }
}

// Copies the view to shared memory. By all threads of a block. Kernel arguments lie in the constant
// bank, and sanitizers report reads of it through a pointer in a non-inlined function.
__device__ inline void take_view(const PoseView& view, PoseSpace& s)
{
    if (threadIdx.x == 0) s.view = view;
    __syncthreads();
}

}  // namespace knead::gpu
