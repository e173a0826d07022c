// One tile of one eye a thread block, one square of 8 x 8 pixels a warp, two pixels a thread. A
// warp's lanes first ask of 32 splats whether they reach its square, each of one; then the warp
// blends those that do.
#include <cuda_fp16.h>

#include "cuda/device/launch.cuh"
#include "cuda/splats/raster.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128, warps = threads / 32;
constexpr int batch = threads;  // splats in shared memory at a time
constexpr int square = 8;       // pixels a side
static_assert(warps * square * square == tile_size * tile_size);

struct Batch {
    float4 shape[batch][2];
    float4 rest[batch];
};

// What there is of a splat in shared memory.
__device__ Footprint<float> footprint(const Batch& b, int j, Vec3<float>& colour)
{
    const float4 p = b.shape[j][0], q = b.shape[j][1], r = b.rest[j];
    Footprint<float> f;
    f.u = p.x, f.v = p.y, f.a = p.z, f.b = p.w, f.c = q.x, f.peak = q.y;
    f.depth = r.y, f.gx = r.z, f.gy = r.w;
    colour = {q.z, q.w, r.x};
    return f;
}

// Two pixels of a thread, one four rows below the other.
struct Two {
    Pixel<float> pixel[2];
    float x, y[2], mesh[2];

    __device__ bool done() const { return knead::done(pixel[0]) && knead::done(pixel[1]); }
    __device__ bool takes_depth() const
    {
        return knead::takes_depth(pixel[0]) || knead::takes_depth(pixel[1]);
    }
};

// The place of a pixel in the pictures; -1 outside.
__device__ int place_of(const RasterView& d, float x, float y)
{
    return x < float(d.width) && y < float(d.height) ? int(y) * d.width + int(x) : -1;
}

template <bool mesh>
__device__ Two begun(const RasterView& d, int e, int x0, int y0, int lane)
{
    Two t;
    t.x = float(x0 + lane % square);
    UNROLL
    for (int k = 0; k < 2; ++k) {
        t.y[k] = float(y0 + lane / square + 4 * k);
        const int at = place_of(d, t.x, t.y[k]);
        t.pixel[k] = {};
        if (at < 0) t.pixel[k].transmittance = 0;
        t.mesh[k] = no_depth;
        if constexpr (mesh)
            if (at >= 0) t.mesh[k] = d.frame->target[e].mesh_depth[at];
    }
    return t;
}

// How a warp blends: pixels whose depth no longer changes are spared it.
enum class Blending { plain, deep, mesh };

template <Blending how>
__device__ void blend_both(Two& t, const Batch& b, int j)
{
    Vec3<float> colour;
    const Footprint<float> f = footprint(b, j, colour);
    UNROLL
    for (int k = 0; k < 2; ++k) {
        if constexpr (how == Blending::mesh)
            blend(t.pixel[k], f, colour, t.x, t.y[k], t.mesh[k]);
        else if constexpr (how == Blending::deep)
            blend_deep(t.pixel[k], f, colour, t.x, t.y[k]);
        else
            blend(t.pixel[k], f, colour, t.x, t.y[k]);
    }
}

// Those of 32 splats, from `first` on, that `in` names.
template <Blending how>
__device__ void blend_named(Two& t, const Batch& b, int first, unsigned in)
{
    for (; in; in &= in - 1) blend_both<how>(t, b, first + lowest_bit(in));
}

// The first n splats of a batch into a warp's square, whose first pixel is (x0, y0).
template <bool mesh>
__device__ void blend_batch(Two& t, const Batch& b, int n, float x0, float y0, int lane)
{
    for (int first = 0; first < n; first += 32) {
        bool in = false;
        if (first + lane < n) {
            Vec3<float> colour;
            in = reaches(footprint(b, first + lane, colour), x0, y0, x0 + (square - 1),
                         y0 + (square - 1));
        }
        const unsigned reached = __ballot_sync(~0u, in);
        if constexpr (mesh)
            blend_named<Blending::mesh>(t, b, first, reached);
        else if (__any_sync(~0u, t.takes_depth()))
            blend_named<Blending::plain>(t, b, first, reached);
        else
            blend_named<Blending::deep>(t, b, first, reached);
        if (__all_sync(~0u, t.done())) return;
    }
}

__device__ unsigned halves(float low, float high)
{
    const __half2 both = __floats2half2_rn(low, high);
    return unsigned(__half_as_ushort(__low2half(both))) |
           unsigned(__half_as_ushort(__high2half(both))) << 16;
}

template <bool mesh>
__device__ void store(const RasterView& d, int e, Two& t)
{
    const RasterTarget& target = d.frame->target[e];
    UNROLL
    for (int k = 0; k < 2; ++k) {
        const int at = place_of(d, t.x, t.y[k]);
        if (at < 0) continue;
        Pixel<float>& p = t.pixel[k];
        Vec3<float> behind = d.frame->background;
        float cover = 0;
        if constexpr (mesh)
            if (t.mesh[k] < no_depth) {
                const uint2 c = target.mesh_colour[at];
                const auto low = [](unsigned w) {
                    return __half2float(__ushort_as_half((unsigned short)(w & 0xffff)));
                };
                behind = {low(c.x), low(c.x >> 16), low(c.y)}, cover = 1;
            }
        finish(p, behind, cover, t.mesh[k]);
        target.colour[at] = {halves(p.colour.x, p.colour.y),
                             halves(p.colour.z, 1 - p.transmittance)};
        target.depth[at] = p.depth;
    }
}

template <bool mesh>
__global__ void __launch_bounds__(threads) blend_kernel(const __grid_constant__ RasterView d)
{
    __shared__ Batch b;
    const int t = int(threadIdx.x), lane = t % 32, warp = t / 32;
    const int tile = int(blockIdx.x), e = tile / d.tiles_of_eye(), row = tile / d.columns;
    const int x0 = (tile - row * d.columns) * tile_size + warp % 2 * square;
    const int y0 = (row - e * d.rows) * tile_size + warp / 2 * square;
    Two two = begun<mesh>(d, e, x0, y0, lane);
    const uint2 range = d.ranges[tile];
    const int from = d.room - int(range.x), to = int(range.y);
    int next = from + t < to ? d.records[0][from + t] : -1;
    for (int first = from; first < to; first += batch) {
        const bool done = __all_sync(~0u, two.done());
        if (__syncthreads_and(done)) break;
        if (next >= 0) {
            const float4* const shape = reinterpret_cast<const float4*>(d.shapes + next);
            b.shape[t][0] = shape[0], b.shape[t][1] = shape[1];
            b.rest[t] = *reinterpret_cast<const float4*>(d.rests + next);
        }
        const int after = first + batch + t;
        next = after < to ? d.records[0][after] : -1;
        __syncthreads();
        if (!done) blend_batch<mesh>(two, b, min(batch, to - first), float(x0), float(y0), lane);
    }
    store<mesh>(d, e, two);
}

}  // namespace

void blend(const RasterView& view, bool mesh, cudaStream_t stream)
{
    launch("blend", mesh ? blend_kernel<true> : blend_kernel<false>, view.all_tiles(), threads,
           stream, view);
}

}  // namespace knead::gpu
