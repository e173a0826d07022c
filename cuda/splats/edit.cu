// Edits of Gaussians between two frames, one thread per Gaussian: rigid motion, order for
// rendering. In double and without contraction of multiply-add, as cuda/mpm/edit.cu, so that
// results are bitwise equal to the host's.
#include <cub/device/device_scan.cuh>

#include "cuda/device/launch.cuh"
#include "cuda/device/ordered.cuh"
#include "cuda/splats/deform.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

__device__ Gaussian<double> moved(const Gaussian<float>& g, const RigidMotion<double>& motion)
{
    Gaussian<double> in_double = cast<double>(g);
    knead::move(in_double, motion);
    return in_double;
}

__global__ void __launch_bounds__(threads)
    move_splats_kernel(const __grid_constant__ GaussianView d, int object,
                       const RigidMotion<double> motion)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= d.count || d.objects[i] != object) return;
    d.store(i, cast<float>(moved(d.load(i), motion)));
}

__global__ void __launch_bounds__(threads)
    splat_extent_kernel(const __grid_constant__ GaussianView d, int object,
                        const RigidMotion<double> motion, Extent* to)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= d.count || d.objects[i] != object) return;
    const Vec3<float> x = cast<float>(moved(d.load(i), motion).x);
    const int keys[3] = {ordered(x.x), ordered(x.y), ordered(x.z)};
    UNROLL
    for (int k = 0; k < 3; ++k) atomicMin(&to->low[k], keys[k]), atomicMax(&to->high[k], keys[k]);
}

// A Gaussian's three rows of 16 bytes are apart on the device; here they are made contiguous.
__global__ void __launch_bounds__(threads)
    arrange_kernel(const __grid_constant__ GaussianView d, float4* to)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= d.count) return;
    const std::size_t at = std::size_t(gaussian_rows) * std::size_t(d.ids[i]);
    UNROLL
    for (int r = 0; r < gaussian_rows; ++r) to[at + r] = d.row(r, i);
}

// Index of each Gaussian, by id.
__global__ void __launch_bounds__(threads) invert_kernel(const int* ids, int count, int* places)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i < count) places[ids[i]] = i;
}

// Stores g as the number-th new Gaussian.
__device__ void append(const GaussianView& d, int number, const Gaussian<float>& g)
{
    const int i = d.count + number;
    d.store(i, g);
    d.sides[i] = g.sides, d.objects[i] = g.object, d.ids[i] = i;
}

__global__ void __launch_bounds__(threads)
    split_kernel(const __grid_constant__ GaussianView d, const GaussianSplit* splits, int count,
                 const int* places, const __grid_constant__ WallOptions walls)
{
    const int k = int(blockIdx.x * threads + threadIdx.x);
    if (k >= count) return;
    const int i = places[splits[k].index];
    Gaussian<float> g = d.load(i);
    g.sides = d.sides[i], g.object = d.objects[i];
    append(d, k, knead::split(g, cast<float>(splits[k].way), walls));
    d.store(i, g);
}

__global__ void __launch_bounds__(threads)
    beside_kernel(const __grid_constant__ GaussianView d, const __grid_constant__ ParticleView q,
                  const GaussianBeside* added, int count, const int* places,
                  const __grid_constant__ WallOptions walls)
{
    const int k = int(blockIdx.x * threads + threadIdx.x);
    if (k >= count) return;
    const Particle<float> p = q.load_state(places[added[k].particle]);
    append(d, k, gaussian_beside(p, cast<float>(added[k].way), walls));
}

// A final 0 makes the last prefix sum the number of Gaussians kept.
__global__ void __launch_bounds__(threads)
    choose_kernel(const __grid_constant__ GaussianView d, const char* gone, int* by_place,
                  int* by_id)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i > d.count) return;
    const bool chosen = i < d.count && !gone[d.objects[i]];
    by_place[i] = chosen, by_id[i < d.count ? d.ids[i] : i] = chosen;
}

// The marks have been replaced by their prefix sums.
__global__ void __launch_bounds__(threads)
    copy_kernel(const __grid_constant__ GaussianView d, const char* gone,
                const __grid_constant__ GaussianView to, const int* by_place, const int* by_id)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= d.count || gone[d.objects[i]]) return;
    const int at = by_place[i];
    UNROLL
    for (int r = 0; r < gaussian_rows; ++r) to.row(r, at) = d.row(r, i);
    to.sides[at] = d.sides[i], to.objects[at] = d.objects[i];
    to.ids[at] = by_id[d.ids[i]];
}

__global__ void __launch_bounds__(threads)
    place_kernel(const __grid_constant__ GaussianView d, const GaussianPlace* placed, int count)
{
    const int k = int(blockIdx.x * threads + threadIdx.x);
    if (k < count) append(d, k, gaussian_at(placed[k].x, placed[k].object));
}

void invert(const int* ids, int count, int* places, cudaStream_t stream)
{
    launch("invert", invert_kernel, blocks_for(count, threads), threads, stream, ids, count,
           places);
}

}  // namespace

void split(const GaussianView& splats, const GaussianSplit* splits, int count, int* places,
           const WallOptions& walls, cudaStream_t stream)
{
    invert(splats.ids, splats.count, places, stream);
    launch("split", split_kernel, blocks_for(count, threads), threads, stream, splats, splits,
           count, places, walls);
}

void add_beside(const GaussianView& splats, const ParticleView& particles,
                const GaussianBeside* added, int count, int* places, const WallOptions& walls,
                cudaStream_t stream)
{
    invert(particles.ids, particles.count, places, stream);
    launch("add beside", beside_kernel, blocks_for(count, threads), threads, stream, splats,
           particles, added, count, places, walls);
}

void place(const GaussianView& splats, const GaussianPlace* placed, int count, cudaStream_t stream)
{
    launch("place", place_kernel, blocks_for(count, threads), threads, stream, splats, placed,
           count);
}

void choose(const GaussianView& splats, const char* gone, int* places, void* scratch,
            std::size_t scratch_bytes, cudaStream_t stream)
{
    const int count = splats.count + 1;
    int* const by_id = places + count;
    launch("choose", choose_kernel, blocks_for(count, threads), threads, stream, splats, gone,
           places, by_id);
    for (int* half : {places, by_id})
        check(cub::DeviceScan::ExclusiveSum(scratch, scratch_bytes, half, half, count, stream),
              "choose");
}

void copy_chosen(const GaussianView& from, const char* gone, const GaussianView& to,
                 const int* places, cudaStream_t stream)
{
    launch("copy chosen", copy_kernel, blocks_for(from.count, threads), threads, stream, from, gone,
           to, places, places + from.count + 1);
}

void arrange(const GaussianView& gaussians, float* rows, cudaStream_t stream)
{
    static_assert(4 * gaussian_rows == MovedGaussians::floats_each);
    launch("arrange splats", arrange_kernel, blocks_for(gaussians.count, threads), threads, stream,
           gaussians, reinterpret_cast<float4*>(rows));
}

void move(const GaussianView& splats, int object, const RigidMotion<double>& motion,
          cudaStream_t stream)
{
    launch("move splats", move_splats_kernel, blocks_for(splats.count, threads), threads, stream,
           splats, object, motion);
}

void extent(const GaussianView& splats, int object, const RigidMotion<double>& motion, Extent* to,
            cudaStream_t stream)
{
    launch("extent of splats", splat_extent_kernel, blocks_for(splats.count, threads), threads,
           stream, splats, object, motion, to);
}

}  // namespace knead::gpu
