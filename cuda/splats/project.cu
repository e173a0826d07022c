// Projection of every splat for each eye: its harmonics are read once and evaluated for both.
#include <cuda_fp16.h>

#include "cuda/device/launch.cuh"
#include "cuda/splats/extrapolate.h"
#include "cuda/splats/raster.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128;

__global__ void set_kernel(RasterFrame* to, const __grid_constant__ RasterFrame frame)
{
    *to = frame;
}

// First tile and number of tiles from `low` to `high` [pixels], clipped to `size`.
__device__ void tiles_between(float low, float high, int size, std::uint16_t& first,
                              std::uint16_t& count)
{
    const float end = float(size - 1);
    const int from = int(ceilf(fmaxf(low, 0.0f))) / tile_size;
    const int to = int(fminf(high, end)) / tile_size;
    first = std::uint16_t(from), count = std::uint16_t(max(to - from + 1, 0));
}

__device__ TileBox box_of(const Footprint<float>& f, const Pinhole<float>& c)
{
    TileBox box;
    tiles_between(f.u - f.half_width, f.u + f.half_width, c.width, box.x, box.columns);
    tiles_between(f.v - f.half_height, f.v + f.half_height, c.height, box.y, box.rows);
    if (box.columns == 0) box.rows = 0;
    return box;
}

// The harmonics of one splat in registers.
template <int degree>
struct Harmonics {
    static constexpr int row = sh_row(degree);
    unsigned words[4 * row];

    __device__ explicit Harmonics(const uint4* from)
    {
        UNROLL
        for (int k = 0; k < row; ++k) {
            const uint4 w = from[k];
            words[4 * k] = w.x, words[4 * k + 1] = w.y;
            words[4 * k + 2] = w.z, words[4 * k + 3] = w.w;
        }
    }
    __device__ float number(int n) const
    {
        const unsigned w = words[n / 2];
        return __half2float(__ushort_as_half((unsigned short)(n & 1 ? w >> 16 : w & 0xffff)));
    }
    __device__ Vec3<float> operator()(int k) const
    {
        return {number(3 * k), number(3 * k + 1), number(3 * k + 2)};
    }
};

struct Posed {
    Vec3<float> centre;
    Mat3<float> half_axes;
    Mat3<float> turn;
};

__device__ Vec3<float> vector_at(const float* x) { return {x[0], x[1], x[2]}; }
__device__ Mat3<float> matrix_at(const float* f)
{
    return {vector_at(f), vector_at(f + 3), vector_at(f + 6)};
}

template <bool moved>
__device__ Posed posed(const RasterView& d, int i, float4 place)
{
    const float4 q = d.frame->splats.turn[i], s = d.frame->splats.scale[i];
    Posed p;
    p.centre = {place.x, place.y, place.z};
    p.half_axes = half_axes(Ellipsoid<float>{{q.w, q.x, q.y, q.z}, {s.x, s.y, s.z}});
    if constexpr (moved) {
        const MovedSplats& m = d.frame->moved;
        if (i >= m.count) {
            p.turn = diagonal(1.0f);
            return p;
        }
        const std::size_t at_x = std::size_t(i) * std::size_t(m.centre_stride);
        const std::size_t at_F = std::size_t(i) * std::size_t(m.F_stride);
        p.centre = vector_at(m.centre + at_x);
        Mat3<float> F = matrix_at(m.F + at_F);
        if (m.centre_before) {
            p.centre = extrapolated(p.centre, vector_at(m.centre_before + at_x), m.extrapolation);
            F = extrapolated(F, matrix_at(m.F_before + at_F), m.extrapolation);
        }
        p.half_axes = F * p.half_axes;
        p.turn = polar_rotation(F);
    }
    return p;
}

template <bool moved, int degree>
__device__ void store(const RasterView& d, int e, int i, const Footprint<float>& f, const Posed& p,
                      const Harmonics<degree>& sh)
{
    const Vec3<float> ray = p.centre - d.frame->camera[e].position;
    Vec3<float> to = rsqrtf(dot(ray, ray)) * ray;
    if constexpr (moved) to = transpose(p.turn) * to;
    const Vec3<float> colour = drawable(sh_colour(degree, to, sh));
    const std::size_t at = std::size_t(e) * std::size_t(d.count) + std::size_t(i);
    float4* const shape = reinterpret_cast<float4*>(d.shapes + at);
    shape[0] = {f.u, f.v, f.a, f.b};
    shape[1] = {f.c, f.peak, colour.x, colour.y};
    *reinterpret_cast<float4*>(d.rests + at) = {colour.z, f.depth, f.gx, f.gy};
}

// Projects the splats in [first, end).
template <bool moved, int degree>
__global__ void __launch_bounds__(threads)
    project_kernel(const __grid_constant__ RasterView d, int first, int end)
{
    const int i = first + int(blockIdx.x) * threads + int(threadIdx.x);
    if (i >= end) return;
    const RasterFrame& frame = *d.frame;
    if (i >= frame.splats.count) {
        d.depth_keys[i] = no_depth_key;
        return;
    }
    const float4 place = frame.splats.place[i];
    const Posed p = posed<moved>(d, i, place);
    Footprint<float> f[2];
    TileBoxes boxes{};
    bool seen = false;
    UNROLL
    for (int e = 0; e < 2; ++e) {
        if (e >= d.eyes) break;
        if (project(frame.camera[e], frame.options, p.centre, p.half_axes, place.w, f[e]))
            boxes.eye[e] = box_of(f[e], frame.camera[e]);
        seen |= boxes.eye[e].rows > 0;
    }
    d.depth_keys[i] = seen ? depth_key(p.centre - frame.middle, frame.options.near) : no_depth_key;
    if (!seen) return;
    const auto words = [](const TileBox& b) {
        return uint2{b.x | unsigned(b.y) << 16, b.columns | unsigned(b.rows) << 16};
    };
    const uint2 left = words(boxes.eye[0]), right = words(boxes.eye[1]);
    *reinterpret_cast<uint4*>(d.boxes + i) = {left.x, left.y, right.x, right.y};
    const Harmonics<degree> sh(frame.splats.sh + std::size_t(i) * Harmonics<degree>::row);
    UNROLL
    for (int e = 0; e < 2; ++e)
        if (boxes.eye[e].rows > 0) store<moved, degree>(d, e, i, f[e], p, sh);
}

template <bool moved, int degree>
void launch_range(const RasterView& view, int first, int end, cudaStream_t stream)
{
    launch("project", project_kernel<moved, degree>, blocks_for(end - first, threads), threads,
           stream, view, first, end);
}

template <int degree>
void launch_project(const RasterView& view, int moved, cudaStream_t stream)
{
    launch_range<true, degree>(view, 0, moved, stream);
    launch_range<false, degree>(view, moved, view.count, stream);
}

}  // namespace

void set_frame(RasterFrame* to, const RasterFrame& frame, cudaStream_t stream)
{
    launch("frame", set_kernel, 1, 1, stream, to, frame);
}

void project(const RasterView& view, int moved, cudaStream_t stream)
{
    switch (view.degree) {
        case 0:
            return launch_project<0>(view, moved, stream);
        case 1:
            return launch_project<1>(view, moved, stream);
        case 2:
            return launch_project<2>(view, moved, stream);
        default:
            return launch_project<3>(view, moved, stream);
    }
}

}  // namespace knead::gpu
