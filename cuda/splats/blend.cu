// Several thread blocks draw what a tile lists, each a part of the tile: a warp a patch of that, a
// thread every second pixel of a column. The threads of a block first ask of 128 splats whether
// they reach its part, each of one; then a warp's lanes of 32 of those whether they reach its
// patch; then the warp blends those that do, the more pixels at once the less it reads.
#include <cuda_fp16.h>

#include "cuda/device/launch.cuh"
#include "cuda/splats/raster.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128, warps = threads / 32;
constexpr int batch = threads;                            // splats in shared memory at a time
constexpr int each = 4;                                   // pixels of a thread: 4 or 8
constexpr int patch_width = 16, patch_height = 2 * each;  // pixels of a warp
constexpr int part_width = 2 * patch_width, part_height = 2 * patch_height;  // of a block
constexpr int parts_across = tile_size / part_width;
constexpr int parts = parts_across * (tile_size / part_height);  // of a tile
static_assert(warps * patch_width * patch_height == part_width * part_height);
static_assert(tile_size % part_width == 0 && tile_size % part_height == 0);
static_assert(square_size % patch_width == 0 && square_size % patch_height == 0);

// Thread blocks of a multiprocessor, by what they need of its registers.
constexpr int resident(bool mesh) { return each == 4 ? (mesh ? 5 : 8) : (mesh ? 4 : 5); }

struct Batch {
    float4 words[3][batch];  // of SplatShape two, of SplatRest one
    int counts[warps];       // that each warp has put into it
};

__device__ Footprint<float> footprint(float4 p, float4 q)
{
    Footprint<float> f;
    f.u = p.x, f.v = p.y, f.a = p.z, f.b = p.w, f.c = q.x, f.peak = q.y;
    return f;
}

// What there is of a splat in shared memory.
__device__ Footprint<float> footprint(const Batch& b, int j, Vec3<float>& colour)
{
    const float4 q = b.words[1][j], r = b.words[2][j];
    Footprint<float> f = footprint(b.words[0][j], q);
    f.depth = r.y, f.gx = r.z, f.gy = r.w;
    colour = {q.z, q.w, r.x};
    return f;
}

// What a thread block draws: a tile's pixels from (x, y) to before (right, bottom), as far as its
// samples go, of which one stands for `step` x `step` pixels.
struct Part {
    int tile, eye, step, x, y, right, bottom;

    __device__ bool has(int2 pixel) const { return pixel.x < right && pixel.y < bottom; }
};

__device__ Part part_of(const RasterView& d, int block)
{
    Part p;
    p.tile = block / parts, p.eye = p.tile / d.tiles_of_eye();
    const int n = block - p.tile * parts, row = p.tile / d.columns;
    const int x = (p.tile - row * d.columns) * tile_size, y = (row - p.eye * d.rows) * tile_size;
    p.step = fovea_step(d.frame->fovea[p.eye], d.frame->camera[p.eye], x, y);
    p.x = x + n % parts_across * part_width * p.step;
    p.y = y + n / parts_across * part_height * p.step;
    p.right = min(x + tile_size, d.width), p.bottom = min(y + tile_size, d.height);
    return p;
}

// The samples of a thread, in one column, two rows apart.
struct Column {
    Pixel<float> pixel[each];
    float x, y, step, mesh[each];  // x, y: of the first
    unsigned hidden;               // bits of those of which nothing is drawn
    bool by_mesh;                  // a mesh is at one of the warp's

    __device__ bool done() const
    {
        bool all = true;
        UNROLL
        for (const Pixel<float>& p : pixel) all = all && knead::done(p);
        return all;
    }
    __device__ bool takes_depth() const
    {
        bool any = false;
        UNROLL
        for (const Pixel<float>& p : pixel) any = any || knead::takes_depth(p);
        return any;
    }
    // The first of the pixels that a sample stands for.
    __device__ int2 corner(int k) const
    {
        const int by = int(step);
        return {int(x) & -by, (int(y) & -by) + 2 * k * by};
    }
};

__device__ bool is_hidden(const RasterView& d, int eye, int2 pixel)
{
    const char* const hidden = d.frame->hidden_squares;
    const int row = eye * d.square_rows() + pixel.y / square_size;
    return hidden && hidden[row * d.square_columns() + pixel.x / square_size];
}

// Of the patch whose first pixel is (x0, y0).
template <bool mesh>
__device__ Column begun(const RasterView& d, const Part& part, int x0, int y0)
{
    const int lane = int(threadIdx.x) % 32, step = part.step;
    Column c;
    c.step = float(step), c.hidden = 0, c.by_mesh = false;
    c.x = float(x0 + lane % patch_width * step) + sample_offset(step);
    c.y = float(y0 + lane / patch_width * step) + sample_offset(step);
    UNROLL
    for (int k = 0; k < each; ++k) {
        const int2 at = c.corner(k);
        const bool in = part.has(at), hidden = in && is_hidden(d, part.eye, at);
        c.pixel[k] = {};
        if (!in || hidden) c.pixel[k].transmittance = 0;
        c.hidden |= hidden ? 1u << k : 0;
        c.mesh[k] = no_depth;
        if constexpr (mesh)
            if (in)
                c.mesh[k] = d.frame->target[part.eye]
                                .mesh_depth[min(at.y + step / 2, d.height - 1) * d.width +
                                            min(at.x + step / 2, d.width - 1)];
        c.by_mesh |= c.mesh[k] < no_depth;
    }
    if constexpr (mesh) c.by_mesh = __any_sync(~0u, c.by_mesh);
    return c;
}

// How a warp blends: pixels whose depth no longer changes are spared it.
enum class Blending { plain, deep, covered, mesh };

template <Blending how>
__device__ void blend_column(Column& c, const Batch& b, int j)
{
    Vec3<float> colour;
    Footprint<float> f = footprint(b, j, colour);
    f.v -= c.y;
    UNROLL
    for (int k = 0; k < each; ++k) {
        const float y = float(2 * k) * c.step;  // from the column's first sample
        if constexpr (how == Blending::mesh)
            blend(c.pixel[k], f, colour, c.x, y, c.mesh[k]);
        else if constexpr (how == Blending::deep)
            blend_deep(c.pixel[k], f, colour, c.x, y);
        else if constexpr (how == Blending::covered)
            blend_covered(c.pixel[k], f, colour, c.x, y);
        else
            blend(c.pixel[k], f, colour, c.x, y);
    }
}

// Those of 32 splats, from `first` on, that `in` names. Near splats mostly cover a patch.
template <Blending how>
__device__ void blend_named(Column& c, const Batch& b, int first, unsigned in, unsigned covering)
{
    for (; in; in &= in - 1) {
        const int k = lowest_bit(in);
        if (how == Blending::deep && (covering >> k & 1))
            blend_column<Blending::covered>(c, b, first + k);
        else
            blend_column<how>(c, b, first + k);
    }
}

// The first n splats of a batch into a warp's patch, whose first sample is at (x0, y0).
template <bool mesh>
__device__ void blend_batch(Column& c, const Batch& b, int n, float x0, float y0)
{
    const int lane = int(threadIdx.x) % 32;
    const float x1 = x0 + (patch_width - 1) * c.step, y1 = y0 + (patch_height - 1) * c.step;
    for (int first = 0; first < n; first += 32) {
        bool in = false, all = false;
        if (first + lane < n) {
            const Footprint<float> f =
                footprint(b.words[0][first + lane], b.words[1][first + lane]);
            in = reaches(f, x0, y0, x1, y1), all = covers(f, x0, y0, x1, y1);
        }
        const unsigned reached = __ballot_sync(~0u, in), covering = __ballot_sync(~0u, all);
        if (mesh && c.by_mesh)
            blend_named<Blending::mesh>(c, b, first, reached, covering);
        else if (__any_sync(~0u, c.takes_depth()))
            blend_named<Blending::plain>(c, b, first, reached, covering);
        else
            blend_named<Blending::deep>(c, b, first, reached, covering);
        if (__all_sync(~0u, c.done())) return;
    }
}

__device__ unsigned halves(float low, float high)
{
    const __half2 both = __floats2half2_rn(low, high);
    return unsigned(__half_as_ushort(__low2half(both))) |
           unsigned(__half_as_ushort(__high2half(both))) << 16;
}

template <bool mesh>
__device__ void store_pixel(const RasterView& d, int e, Pixel<float> p, int at)
{
    const RasterTarget& target = d.frame->target[e];
    Vec3<float> behind = d.frame->background;
    float cover = 0, depth = no_depth;
    if constexpr (mesh) depth = target.mesh_depth[at];
    if (mesh && depth < no_depth) {
        const uint2 m = target.mesh_colour[at];
        const auto low = [](unsigned w) {
            return __half2float(__ushort_as_half((unsigned short)(w & 0xffff)));
        };
        behind = {low(m.x), low(m.x >> 16), low(m.y)}, cover = 1;
    }
    finish(p, behind, cover, depth);
    target.colour[at] = {halves(p.colour.x, p.colour.y), halves(p.colour.z, 1 - p.transmittance)};
    target.depth[at] = p.depth;
}

// All pixels that the samples stand for, each before what lies behind it.
template <bool mesh>
__device__ void store(const RasterView& d, const Part& part, const Column& c)
{
    UNROLL
    for (int k = 0; k < each; ++k) {
        const Pixel<float> p = c.hidden >> k & 1 ? Pixel<float>{} : c.pixel[k];
        const int2 first = c.corner(k);
        for (int y = first.y; y < min(first.y + part.step, part.bottom); ++y)
            for (int x = first.x; x < min(first.x + part.step, part.right); ++x)
                store_pixel<mesh>(d, part.eye, p, y * d.width + x);
    }
}

// A splat on its way into a batch: not in, if it does not reach the part.
struct Entry {
    float4 words[3];
    bool in;
};
__device__ Entry entry_of(const RasterView& d, const Part& part, int record)
{
    Entry n{};
    if (record < 0) return n;
    const float4* const shape = reinterpret_cast<const float4*>(d.shapes + record);
    n.words[0] = shape[0], n.words[1] = shape[1];
    const float x = float(part.x) + sample_offset(part.step),
                y = float(part.y) + sample_offset(part.step);
    n.in = reaches(footprint(n.words[0], n.words[1]), x, y, x + float((part_width - 1) * part.step),
                   y + float((part_height - 1) * part.step));
    if (n.in) n.words[2] = *reinterpret_cast<const float4*>(d.rests + record);
    return n;
}

// Puts those that are in into the batch, in their order; how many. `lanes`: of the warp. Between
// two barriers, once every warp has told its count.
__device__ int put(Batch& b, const Entry& n, unsigned lanes)
{
    const int lane = int(threadIdx.x) % 32, warp = int(threadIdx.x) / 32;
    int at = __popc(lanes & ((1u << lane) - 1)), all = 0;
    UNROLL
    for (int w = 0; w < warps; ++w) {
        const int count = b.counts[w];
        if (w < warp) at += count;
        all += count;
    }
    if (n.in) {
        UNROLL
        for (int k = 0; k < 3; ++k) b.words[k][at] = n.words[k];
    }
    return all;
}

template <bool mesh>
__global__ void __launch_bounds__(threads, resident(mesh))
    blend_kernel(const __grid_constant__ RasterView d)
{
    __shared__ Batch b;
    const int t = int(threadIdx.x), warp = t / 32;
    const Part part = part_of(d, int(blockIdx.x));
    if (!part.has({part.x, part.y})) return;
    const int x0 = part.x + warp % 2 * patch_width * part.step;
    const int y0 = part.y + warp / 2 * patch_height * part.step;
    Column c = begun<mesh>(d, part, x0, y0);
    const uint2 range = d.ranges[part.tile];
    const int from = d.room - int(range.x), to = int(range.y);
    int next = from + t < to ? d.records[0][from + t] : -1;
    for (int first = from; first < to; first += batch) {
        const bool done = __all_sync(~0u, c.done());
        const Entry entry = entry_of(d, part, next);
        const unsigned lanes = __ballot_sync(~0u, entry.in);
        if (t % 32 == 0) b.counts[warp] = __popc(lanes);
        if (__syncthreads_and(done)) break;
        const int n = put(b, entry, lanes);
        const int after = first + batch + t;
        next = after < to ? d.records[0][after] : -1;
        __syncthreads();
        if (!done)
            blend_batch<mesh>(c, b, n, float(x0) + sample_offset(part.step),
                              float(y0) + sample_offset(part.step));
    }
    store<mesh>(d, part, c);
}

}  // namespace

void blend(const RasterView& view, bool mesh, cudaStream_t stream)
{
    launch("blend", mesh ? blend_kernel<true> : blend_kernel<false>, view.all_tiles() * parts,
           threads, stream, view);
}

}  // namespace knead::gpu
