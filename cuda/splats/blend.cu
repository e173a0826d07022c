// A thread block draws a part of a tile, a warp a patch of the part, and a thread every second
// pixel of a column of the patch. First the threads of a block test 128 splats of the list against
// its part, one each: most splats of a whole list may not reach the part. Then the lanes of a warp
// test 32 of the splats that do against its patch. Then the warp blends those that reach the patch;
// more pixels per thread mean fewer reads. While a batch of splats is blended, the next one is
// loaded.
// Parts with long lists by parts are deferred, since few blocks would each have much serial work:
// four blocks draw a quarter each, with one pixel per thread.
#include <cuda_fp16.h>
#include <cuda_pipeline.h>

#include "cuda/device/launch.cuh"
#include "cuda/splats/raster.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 128, warps = threads / 32;
constexpr int batch = threads;        // entries of a list tested at a time
constexpr int rest_blocks = 132 * 8;  // an H200's
constexpr int quarters = 4;           // thread blocks per deferred part

// The area that a block draws: a part, or a quarter of one; four patches, two by two, one per warp.
struct PartSize {
    static constexpr int each = 4;  // pixels of a thread
    static constexpr int patch_width = 16, patch_height = 8;
};
struct QuarterSize {
    static constexpr int each = 1;
    static constexpr int patch_width = 8, patch_height = 4;
};
static_assert(2 * PartSize::patch_width == part_width && 2 * PartSize::patch_height == part_height);
static_assert(PartSize::patch_width == 2 * QuarterSize::patch_width &&
              PartSize::patch_height == 2 * QuarterSize::patch_height && warps == 4);

// Resident thread blocks per multiprocessor, by register use.
template <class Size, bool mesh>
constexpr int resident = Size::each == 1 ? 8
                         : mesh          ? 5
                                         : 8;

struct Batch {
    float4 words[3][batch];  // of SplatShape two, of SplatRest one
    int counts[warps];       // number of entries of each warp
};

__device__ Footprint<float> footprint(float4 p, float4 q)
{
    Footprint<float> f;
    f.u = p.x, f.v = p.y, f.a = p.z, f.b = p.w, f.c = q.x, f.peak = q.y;
    return f;
}

// A splat's data in shared memory.
__device__ Footprint<float> footprint(const Batch& b, int j, Vec3<float>& colour)
{
    const float4 q = b.words[1][j], r = b.words[2][j];
    Footprint<float> f = footprint(b.words[0][j], q);
    f.depth = r.y, f.gx = r.z, f.gy = r.w;
    colour = {q.z, q.w, r.x};
    return f;
}

// The area of a thread block: the samples of a part of a tile, each covering `step` x `step`
// pixels.
struct TilePart {
    int key, tile, eye, x, y;  // (x, y): the tile's first pixel
    int step;
    PartBox box;

    __device__ int left() const { return x + box.x; }
    __device__ int top() const { return y + box.y; }
    __device__ bool has(const RasterView& d, int2 pixel) const
    {
        return pixel.x < min(left() + box.width, d.width) &&
               pixel.y < min(top() + box.height, d.height);
    }
};

__device__ TilePart part_of(const RasterView& d, int key)
{
    const int tile = key / parts, n = key - tile * parts;
    const int eye = tile / d.tiles_of_eye(), row = tile / d.columns, step = d.rules[tile].step;
    return {key,
            tile,
            eye,
            (tile - row * d.columns) * tile_size,
            (row - eye * d.rows) * tile_size,
            step,
            part_box(n, step)};
}

// One of its quarters.
__device__ TilePart quarter_of(TilePart p, int n)
{
    constexpr int width = part_width / 2, height = part_height / 2;
    const int x = n % 2 * width * p.step, y = n / 2 * height * p.step;
    p.box = {p.box.x + x, p.box.y + y, clamp(p.box.width - x, 0, width * p.step),
             clamp(p.box.height - y, 0, height * p.step)};
    return p;
}

// The samples of a thread, in one column, spaced by the rows that a warp covers at a time.
template <class Size>
struct Column {
    static constexpr int each = Size::each, rows = 32 / Size::patch_width;
    Pixel<float> pixel[each];
    float x, y, step, mesh[each];  // x, y: of the first
    unsigned hidden;               // bits of samples where nothing is drawn
    bool by_mesh;                  // a sample of the warp has a mesh

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
    // The first of the pixels that a sample covers.
    __device__ int2 corner(int k) const
    {
        const int by = int(step);
        return {int(x) & -by, (int(y) & -by) + rows * k * by};
    }
};

__device__ bool is_hidden(const RasterView& d, int eye, int2 pixel)
{
    const char* const hidden = d.frame->hidden;
    const int row = eye * d.square_rows() + pixel.y / square_size;
    return hidden && hidden[row * d.square_columns() + pixel.x / square_size];
}

// Mesh depth of a sample, at its middle pixel.
__device__ float mesh_at(const RasterView& d, const TilePart& part, int2 corner)
{
    const int x = min(corner.x + part.step / 2, d.width - 1);
    const int y = min(corner.y + part.step / 2, d.height - 1);
    return d.frame->target[part.eye].mesh_depth[y * d.width + x];
}

// Samples of the patch whose first pixel is (x0, y0).
template <class Size, bool mesh>
__device__ Column<Size> begun(const RasterView& d, const TilePart& part, int x0, int y0)
{
    const int lane = int(threadIdx.x) % 32, step = part.step;
    Column<Size> c;
    c.x = float(x0 + lane % Size::patch_width * step) + sample_offset(step);
    c.y = float(y0 + lane / Size::patch_width * step) + sample_offset(step);
    c.step = float(step), c.hidden = 0, c.by_mesh = false;
    UNROLL
    for (int k = 0; k < Size::each; ++k) {
        const int2 at = c.corner(k);
        const bool in = part.has(d, at), hidden = in && is_hidden(d, part.eye, at);
        c.pixel[k] = {};
        if (!in || hidden) c.pixel[k].transmittance = 0;
        c.hidden |= hidden ? 1u << k : 0;
        c.mesh[k] = no_depth;
        if constexpr (mesh)
            if (in) c.mesh[k] = mesh_at(d, part, at);
        c.by_mesh |= c.mesh[k] < no_depth;
    }
    if constexpr (mesh) c.by_mesh = __any_sync(~0u, c.by_mesh);
    return c;
}

// Variants of blending: pixels whose depth is final skip it.
enum class Blending { plain, deep, covered, mesh };

template <Blending how, class Size>
__device__ void blend_column(Column<Size>& c, const Batch& b, int j)
{
    Vec3<float> colour;
    Footprint<float> f = footprint(b, j, colour);
    f.v -= c.y;
    UNROLL
    for (int k = 0; k < Size::each; ++k) {
        const float y = float(c.rows * k) * c.step;  // from the column's first sample
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

// Blends the splats among 32, from `first` on, whose bits are set in `in`. Near splats mostly cover
// a patch.
template <Blending how, class Size>
__device__ void blend_named(Column<Size>& c, const Batch& b, int first, unsigned in,
                            unsigned covering)
{
    for (; in; in &= in - 1) {
        const int k = lowest_bit(in);
        if (how == Blending::deep && (covering >> k & 1))
            blend_column<Blending::covered>(c, b, first + k);
        else
            blend_column<how>(c, b, first + k);
    }
}

// Blends the first n splats of a batch into a warp's patch, whose first sample is at (x0, y0).
template <class Size, bool mesh>
__device__ void blend_batch(Column<Size>& c, const Batch& b, int n, float x0, float y0)
{
    const int lane = int(threadIdx.x) % 32;
    const float x1 = x0 + (Size::patch_width - 1) * c.step;
    const float y1 = y0 + (Size::patch_height - 1) * c.step;
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

// Stores all pixels covered by the samples, composited over mesh or background.
template <class Size, bool mesh>
__device__ void store(const RasterView& d, const TilePart& part, const Column<Size>& c)
{
    UNROLL
    for (int k = 0; k < Size::each; ++k) {
        const Pixel<float> p = c.hidden >> k & 1 ? Pixel<float>{} : c.pixel[k];
        const int2 first = c.corner(k);
        for (int y = first.y; y < first.y + part.step; ++y)
            for (int x = first.x; x < first.x + part.step; ++x)
                if (part.has(d, {x, y})) store_pixel<mesh>(d, part.eye, p, y * d.width + x);
    }
}

// An entry of a list, as tested by a thread; record -1: none.
struct Entry {
    int record;
    float4 shape[2];
};
__device__ Entry entry_of(const RasterView& d, int record)
{
    Entry n{};
    n.record = record;
    if (record < 0) return n;
    const float4* const shape = reinterpret_cast<const float4*>(d.shapes + record);
    n.shape[0] = shape[0], n.shape[1] = shape[1];
    return n;
}
__device__ bool is_in(const TilePart& part, const Entry& n)
{
    return n.record >= 0 &&
           reaches_part(footprint(n.shape[0], n.shape[1]), part.x, part.y, part.box, part.step);
}

// Appends the entries of `lanes` to the batch, in order; returns the batch's size. `lanes`: mask of
// the warp. Call after the barrier that publishes the warps' counts; complete once the copy is
// waited for.
__device__ int put(const RasterView& d, Batch& b, const Entry& n, unsigned lanes)
{
    const int lane = int(threadIdx.x) % 32, warp = int(threadIdx.x) / 32;
    int at = __popc(lanes & ((1u << lane) - 1)), all = 0;
    UNROLL
    for (int w = 0; w < warps; ++w) {
        const int count = b.counts[w];
        if (w < warp) at += count;
        all += count;
    }
    if (lanes >> lane & 1) {
        b.words[0][at] = n.shape[0], b.words[1][at] = n.shape[1];
        __pipeline_memcpy_async(&b.words[2][at], d.rests + n.record, sizeof b.words[2][at]);
    }
    __pipeline_commit();
    return all;
}

// Range of a part's list.
struct Range {
    int from, to;
};
__device__ Range range_of(const RasterView& d, const TilePart& part)
{
    const uint2 range = d.ranges[d.rules[part.tile].whole ? part.tile * parts : part.key];
    return {range.y ? d.room - int(range.x) : 0, int(range.y)};
}

// One barrier per batch: at it all warps have finished the previous batch, so its buffer can be
// reused.
template <class Size, bool mesh>
__device__ void blend_list(const RasterView& d, const TilePart& part, const Range& range,
                           Column<Size>& c, float x0, float y0)
{
    __shared__ Batch both[2];
    const int t = int(threadIdx.x), warp = t / 32, to = range.to;
    const auto record_at = [&](int at) { return at < to ? d.records[0][at] : -1; };
    Entry entry = entry_of(d, record_at(range.from + t));
    int record = record_at(range.from + batch + t), before = 0, side = 0;
    for (int first = range.from; first < to || before > 0; first += batch, side ^= 1) {
        Batch& b = both[side];
        const bool done = __all_sync(~0u, c.done());
        const unsigned lanes = __ballot_sync(~0u, is_in(part, entry));
        if (t % 32 == 0) b.counts[warp] = __popc(lanes);
        if (__syncthreads_and(done)) break;
        const int n = put(d, b, entry, lanes);
        entry = entry_of(d, record);
        record = record_at(first + 2 * batch + t);
        if (!done) blend_batch<Size, mesh>(c, both[side ^ 1], before, x0, y0);
        __pipeline_wait_prior(0);
        before = n;
    }
}

template <class Size, bool mesh>
__device__ void draw(const RasterView& d, const TilePart& part, const Range& range)
{
    if (!part.has(d, {part.left(), part.top()})) return;
    const int warp = int(threadIdx.x) / 32;
    const int x0 = part.left() + warp % 2 * Size::patch_width * part.step;
    const int y0 = part.top() + warp / 2 * Size::patch_height * part.step;
    Column<Size> c = begun<Size, mesh>(d, part, x0, y0);
    const float offset = sample_offset(part.step);
    blend_list<Size, mesh>(d, part, range, c, float(x0) + offset, float(y0) + offset);
    store<Size, mesh>(d, part, c);
}

template <bool mesh>
__global__ void __launch_bounds__(threads, resident<PartSize, mesh>)
    blend_kernel(const __grid_constant__ RasterView d)
{
    const TilePart part = part_of(d, int(blockIdx.x));
    const Range range = range_of(d, part);
    if (!d.rules[part.tile].whole && range.to - range.from > max_list_per_block) {
        if (threadIdx.x == 0) d.deferred[atomicAdd(&d.counts->deferred, 1)] = part.key;
        return;
    }
    draw<PartSize, mesh>(d, part, range);
}

// Deferred parts.
template <bool mesh>
__global__ void __launch_bounds__(threads, resident<QuarterSize, mesh>)
    blend_rest_kernel(const __grid_constant__ RasterView d)
{
    const int all = quarters * d.counts->deferred;
    for (int k = int(blockIdx.x); k < all; k += int(gridDim.x)) {
        const TilePart part = part_of(d, d.deferred[k / quarters]);
        draw<QuarterSize, mesh>(d, quarter_of(part, k % quarters), range_of(d, part));
        __syncthreads();
    }
}

}  // namespace

void blend(const RasterView& view, bool mesh, cudaStream_t stream)
{
    launch("blend", mesh ? blend_kernel<true> : blend_kernel<false>, view.all_keys(), threads,
           stream, view);
    launch("blend", mesh ? blend_rest_kernel<true> : blend_rest_kernel<false>, rest_blocks, threads,
           stream, view);
}

}  // namespace knead::gpu
