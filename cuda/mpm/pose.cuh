// Tools for one substep: joints between the frame's ends, spheres hung on them, shapes derived from
// the spheres.
#pragma once
#include <cuda/atomic>

#include "cuda/contact/skinning.h"
#include "cuda/mpm/views.cuh"

namespace knead::gpu {

// The work is shared by so many thread blocks, each of which poses the spheres that its primitives
// need: spheres of two parts are posed twice, to the same bits.
constexpr int part_primitives = max_primitives / pose_parts;

// Index of the k-th primitive of a part.
__device__ inline int primitive_of(int part, int k) { return part + k * pose_parts; }

// Of so many joints each is interpolated once for all spheres; of more, those of a few spheres at a
// time, four each.
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

// The sphere of a part's primitives, three each, that comes k-th; -1: there is none.
__device__ inline int sphere_of(const RigView& t, int part, int k)
{
    const int i = primitive_of(part, k / 3);
    return i < t.primitives.count ? t.primitives[i].sphere[k % 3] : -1;
}

// Called by all threads of a block, with the view in place; poses for substep n.
__device__ inline void pose_viewed(PoseSpace& s, int part, int n)
{
    const PoseView& t = s.view;
    const Step& step = t.clock->step(n);
    const double duration = t.clock->duration, dt = step.dt;
    const double from = step.start / duration, to = (step.start + dt) / duration;
    const int thread = int(threadIdx.x), threads = int(blockDim.x), parity = n & 1;
    const bool staged = t.joints <= staged_joints;
    constexpr int count = 3 * part_primitives;
    const int together = staged ? count : staged_spheres;
    // Asked for early, and of memory twice in a row: not where a sphere is waited for.
    for (int k = thread; k < part_primitives && primitive_of(part, k) < t.primitives.count;
         k += threads) {
        const Tool<float>& tool = t.tools[t.primitives[primitive_of(part, k)].tool];
        s.sizes[k] = tool.size;
        s.across[k] = tool.stretch.across, s.along[k] = tool.stretch.along;
    }
    for (int first = 0; first < count; first += together) {
        __syncthreads();  // those before have been read
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

// By all threads of a block. The view goes to shared memory: a kernel's argument lies in the
// constant bank, and what a function out of line reads of it through a pointer, no sanitizer can
// tell from a fault.
__device__ inline void take_view(const PoseView& view, PoseSpace& s)
{
    if (threadIdx.x == 0) s.view = view;
    __syncthreads();
}

// By all threads of a block: waits until the clock's own block of grid has begun substep n, and
// chosen the one after it.
__device__ inline void await_begun(Clock& clock, int n)
{
    if (threadIdx.x == 0) {
        const cuda::atomic_ref<int, cuda::thread_scope_device> begun(clock.begun);
        while (begun.load(cuda::memory_order_acquire) != n) __nanosleep(100);
    }
    __syncthreads();
}
__device__ inline void note_begun(Clock& clock, int n)
{
    cuda::atomic_ref<int, cuda::thread_scope_device>(clock.begun)
        .store(n, cuda::memory_order_release);
}

// By all threads of a block, when they have posed: substep n's shapes of that part are there.
__device__ inline void note_posed(Clock& clock, int part, int n)
{
    __syncthreads();
    if (threadIdx.x != 0) return;
    cuda::atomic_ref<int, cuda::thread_scope_device>(clock.posed[part])
        .store(n, cuda::memory_order_release);
}
// By all threads of a block, with the view in place: poses for the substep under way; or, `ahead`,
// for the one after it as soon as its length is chosen, which grid may still be at. Kept out of
// line: its registers are not those of the kernel that it shares a launch with.
static __device__ __noinline__ void pose_part(PoseSpace& s, int part, bool ahead)
{
    Clock& clock = *s.view.clock;
    const int n = __ldcg(&clock.done);
    if (ahead) await_begun(clock, n);
    if (ahead && !(clock.dt[0] > 0 && clock.dt[1] > 0)) return;
    pose_viewed(s, part, n + ahead);
    if (ahead) note_posed(clock, part, n + 1);
}

// For which substep they are there, to be followed by saw_posed() before they are read.
__device__ inline int posed_for(const Clock& clock, int part)
{
    return cuda::atomic_ref<const int, cuda::thread_scope_device>(clock.posed[part])
        .load(cuda::memory_order_relaxed);
}
__device__ inline void saw_posed()
{
    cuda::atomic_thread_fence(cuda::memory_order_acquire, cuda::thread_scope_device);
}

}  // namespace knead::gpu
