// Gaussians between two frames, one thread each: moved with their object, arranged to be drawn. As
// cuda/mpm/edit.cu: in double and without contraction of multiply-add, so that they have the bits
// that the host would compute.
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

// A Gaussian's rows on the device are three of 16 bytes apart; here they follow each other.
__global__ void __launch_bounds__(threads)
    arrange_kernel(const __grid_constant__ GaussianView d, float4* to)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= d.count) return;
    const std::size_t at = std::size_t(gaussian_rows) * std::size_t(d.ids[i]);
    UNROLL
    for (int r = 0; r < gaussian_rows; ++r) to[at + r] = d.row(r, i);
}

}  // namespace

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
