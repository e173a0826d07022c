// One thread per particle, or per Sliding record. Compiled without contraction of multiply-add, and
// in double where positions change: the result is bitwise equal to the same edit on the host.
#include <cub/device/device_scan.cuh>

#include "cuda/device/launch.cuh"
#include "cuda/device/ordered.cuh"
#include "cuda/mpm/edit.cuh"
#include "cuda/mpm/material.h"
#include "cuda/mpm/stencil.h"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

// The object of particle i.
__device__ int object_of(const ParticleView& p, int i) { return __float_as_int(p.row(1, i).w); }

struct Chosen {
    ParticleView particles;
    int object;
    __device__ bool has(int i) const
    {
        return i < particles.count && (object == every_object || object_of(particles, i) == object);
    }
};

__device__ Particle<double> moved(Particle<float> q, const RigidMotion<double>& motion)
{
    q.hold(false);
    Particle<double> in_double = cast<double>(q);
    move(in_double, motion);
    return in_double;
}

__global__ void __launch_bounds__(threads)
    extent_kernel(const Chosen chosen, const Materials materials, const RigidMotion<double> motion,
                  bool still, Extent* to)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    const bool valid = chosen.has(i);
    Particle<float> q{};
    if (valid) q = chosen.particles.load(i);
    const Vec3<float> x = still || !valid ? q.x : cast<float>(moved(q, motion).x);
    const unsigned fastest = __reduce_max_sync(~0u, __float_as_uint(dot(q.v, q.v)));
    const unsigned stiffest =
        __reduce_max_sync(~0u, valid ? __float_as_uint(stiffness(q, materials[q.object])) : 0);
    const float places[3] = {x.x, x.y, x.z};
    const bool first = (threadIdx.x & 31) == 0;
    if (first && fastest) atomicMax(&to->peak.fastest, fastest);
    if (first && stiffest) atomicMax(&to->peak.stiffest, stiffest);
    UNROLL
    for (int k = 0; k < 3; ++k) {
        const int key = ordered(places[k]);
        const int low = __reduce_min_sync(~0u, valid ? key : 0x7f7fffff);
        const int high = __reduce_max_sync(~0u, valid ? key : ~0x7f7fffff);
        if (first) atomicMin(&to->low[k], low), atomicMax(&to->high[k], high);
    }
}

__global__ void __launch_bounds__(threads)
    move_kernel(const Chosen chosen, const RigidMotion<double> motion)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (!chosen.has(i)) return;
    chosen.particles.store(i, cast<float>(moved(chosen.particles.load(i), motion)));
}

__global__ void __launch_bounds__(threads)
    law_kernel(const Chosen chosen, Plasticity from, Plasticity to)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (!chosen.has(i)) return;
    Particle<float> q = chosen.particles.load(i);
    q.hold(false);
    change_law(q, from, to);
    chosen.particles.store(i, q);
}

__global__ void __launch_bounds__(threads)
    wake_kernel(const Chosen chosen, const __grid_constant__ Lattice<float> lattice, int* quiet)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (!chosen.has(i)) return;
    const Int3 base = base_node(chosen.particles.position(i), lattice.spacing);
    quiet[lattice.block_of(base)] = 0;
}

// 1 for particles that are kept, by index and by id.
__global__ void __launch_bounds__(threads)
    mark_kernel(const ParticleView from, const char* gone, int* by_place, int* by_id)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= from.count) return;
    by_place[i] = by_id[from.ids[i]] = gone[object_of(from, i)] ? 0 : 1;
}

// The marks have been replaced by their prefix sums.
__global__ void __launch_bounds__(threads)
    keep_kernel(const ParticleView from, const char* gone, const ParticleView to,
                const int* by_place, const int* by_id)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= from.count || gone[object_of(from, i)]) return;
    const int at = by_place[i];
    for (int r = 0; r < particle_rows; ++r) to.row(r, at) = from.row(r, i);
    to.ids[at] = by_id[from.ids[i]];
}

__global__ void __launch_bounds__(threads) id_kernel(const ParticleView from, const ParticleView to)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= from.count) return;
    const int id = from.ids[i];
    for (int r = 0; r < particle_rows; ++r) to.row(r, id) = from.row(r, i);
    to.ids[id] = id;
}

__global__ void __launch_bounds__(threads)
    to_planes_kernel(const ConstParticleView from, float* planes)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= from.count) return;
    const Particle<float> q = from.load_state(i);
    const float words[plane_words] = {q.x.x,
                                      q.x.y,
                                      q.x.z,
                                      q.e.xx,
                                      q.e.yy,
                                      q.e.zz,
                                      q.e.xy,
                                      q.e.xz,
                                      q.e.yz,
                                      q.k,
                                      __int_as_float(q.object),
                                      __uint_as_float(q.label())};
    float* to = planes + from.ids[i];
    UNROLL
    for (int p = 0; p < plane_words; ++p) to[std::size_t(p) * std::size_t(from.count)] = words[p];
}

// Writes the first three rows; the others stay.
__global__ void __launch_bounds__(threads)
    from_planes_kernel(const float* planes, const ParticleView to)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= to.count) return;
    float words[plane_words];
    UNROLL
    for (int p = 0; p < plane_words; ++p)
        words[p] = planes[std::size_t(p) * std::size_t(to.count) + std::size_t(i)];
    Particle<float> q{};
    q.x = {words[0], words[1], words[2]};
    q.e = {words[3], words[4], words[5], words[6], words[7], words[8]};
    q.k = words[9], q.object = __float_as_int(words[10]), q.sides = __float_as_uint(words[11]);
    to.store_state(i, q);
    to.ids[i] = i;
}

int blocks_of(const ParticleView& particles) { return blocks_for(particles.count, threads); }

bool identity(const RigidMotion<double>& m)
{
    return m.q.w == 1 && m.p.x == 0 && m.p.y == 0 && m.p.z == 0;
}

// Records of the last substep at the time of the copy become records of the current last substep.
__global__ void __launch_bounds__(threads)
    slide_kernel(Sliding<float>* all, int count, const int* then, const Clock* clock)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= count) return;
    int& substep = all[i].substep;
    substep = substep == *then - 1 ? clock->done - 1 : 0;
}

}  // namespace

void extent(const ParticleView& particles, const Materials& materials, int object,
            const RigidMotion<double>& motion, Extent* to, cudaStream_t stream)
{
    launch("extent", extent_kernel, blocks_of(particles), threads, stream,
           Chosen{particles, object}, materials, motion, identity(motion), to);
}

void move(const ParticleView& particles, int object, const RigidMotion<double>& motion,
          cudaStream_t stream)
{
    launch("move", move_kernel, blocks_of(particles), threads, stream, Chosen{particles, object},
           motion);
}

void change_law(const ParticleView& particles, int object, Plasticity from, Plasticity to,
                cudaStream_t stream)
{
    launch("change law", law_kernel, blocks_of(particles), threads, stream,
           Chosen{particles, object}, from, to);
}

void wake(const ParticleView& particles, int object, const Lattice<float>& lattice, int* quiet,
          cudaStream_t stream)
{
    launch("wake", wake_kernel, blocks_of(particles), threads, stream, Chosen{particles, object},
           lattice, quiet);
}

std::size_t keep_scratch_bytes(int count)
{
    std::size_t bytes = 0;
    int* none = nullptr;
    check(cub::DeviceScan::ExclusiveSum(nullptr, bytes, none, none, count), "keep");
    return bytes;
}

void keep_others(const ParticleView& from, const char* gone, const ParticleView& to, int* places,
                 void* scratch, std::size_t scratch_bytes, cudaStream_t stream)
{
    int* const by_id = places + from.count;
    launch("mark", mark_kernel, blocks_of(from), threads, stream, from, gone, places, by_id);
    for (int* marks : {places, by_id})
        check(
            cub::DeviceScan::ExclusiveSum(scratch, scratch_bytes, marks, marks, from.count, stream),
            "keep");
    launch("keep", keep_kernel, blocks_of(from), threads, stream, from, gone, to, places, by_id);
}

void slide_on(Sliding<float>* all, int count, const int* then, const Clock* clock,
              cudaStream_t stream)
{
    if (count == 0) return;
    launch("slide on", slide_kernel, (count + threads - 1) / threads, threads, stream, all, count,
           then, clock);
}

void to_planes(const ConstParticleView& from, float* planes, cudaStream_t stream)
{
    launch("to planes", to_planes_kernel, blocks_for(from.count, threads), threads, stream, from,
           planes);
}

void from_planes(const float* planes, const ParticleView& to, cudaStream_t stream)
{
    if (to.count == 0) return;
    launch("from planes", from_planes_kernel, blocks_of(to), threads, stream, planes, to);
    const std::size_t row = std::size_t(to.count) * sizeof(float4);
    check(cudaMemsetAsync(&to.row(3, 0), 0, (particle_rows - 3) * row, stream), "from planes");
}

void order_by_id(const ParticleView& from, const ParticleView& to, cudaStream_t stream)
{
    launch("order by id", id_kernel, blocks_of(from), threads, stream, from, to);
}

}  // namespace knead::gpu
