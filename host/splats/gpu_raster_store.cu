#include <cuda_fp16.h>

#include <numeric>
#include <stdexcept>
#include <string>

#include "host/splats/gpu_raster_store.cuh"

namespace knead::gpu {
namespace {

// Halves reach to 65504; what is not finite stays so, and is drawn black.
std::vector<uint4> harmonics_rows(const SplatCloud& cloud)
{
    const auto coefficients = std::size_t(harmonics(cloud.degree));
    const auto row = std::size_t(sh_row(cloud.degree));
    std::vector<uint4> rows(cloud.count() * row);
    std::vector<__half> halves(8 * row);
    for (std::size_t i = 0; i < cloud.count(); ++i) {
        const Vec3<float>* const sh = cloud.sh.data() + i * coefficients;
        for (std::size_t k = 0; k < coefficients; ++k) {
            halves[3 * k] = __float2half_rn(sh[k].x);
            halves[3 * k + 1] = __float2half_rn(sh[k].y);
            halves[3 * k + 2] = __float2half_rn(sh[k].z);
        }
        std::memcpy(rows.data() + i * row, halves.data(), row * sizeof(uint4));
    }
    return rows;
}

}  // namespace

// For which there is room, for each instance for which there is.
constexpr std::size_t candidates_each = 8;

RasterStore::RasterStore(const SplatCloud& cloud)
{
    SplatFrame any;
    any.eyes = {{{0, 0, 0}, {1, 0, 0, 0}, -1, 1, -1, 1, 1, 1}};
    check_frame(cloud, any);
    const std::size_t n = cloud.count();
    upload_splats(cloud);
    frame = DeviceArray<RasterFrame>(1);
    counts = DeviceArray<RasterCounts>(1);
    depth_keys = DeviceArray<std::uint32_t>(n), sorted_keys = DeviceArray<std::uint32_t>(n);
    boxes = DeviceArray<TileBoxes>(n);
    shapes = DeviceArray<SplatShape>(2 * n), rests = DeviceArray<SplatRest>(2 * n);
    std::vector<int> each(n);
    std::iota(each.begin(), each.end(), 0);
    numbers = DeviceArray<int>(each), order = DeviceArray<int>(n);
    candidate_starts = DeviceArray<unsigned long long>(n + 1);
    view.frame = frame.data();
    view.depth_keys = depth_keys.data(), view.sorted_keys = sorted_keys.data();
    view.boxes = boxes.data(), view.shapes = shapes.data(), view.rests = rests.data();
    view.numbers = numbers.data(), view.order = order.data();
    view.candidate_starts = candidate_starts.data();
    view.counts = counts.data();
    digit_counts = DeviceArray<unsigned>(digit_table_size);
    digit_starts = DeviceArray<unsigned>(digit_table_size);
    view.digit_counts = digit_counts.data(), view.digit_starts = digit_starts.data();
    scratch_memory = DeviceArray<unsigned char>(raster_scratch_bytes(view.splats.count));
    scratch = {scratch_memory.data(), scratch_memory.bytes()};
}

void RasterStore::upload_splats(const SplatCloud& cloud)
{
    const std::size_t n = cloud.count();
    std::vector<float4> places(n), turns(n), scales(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3<float> x = cloud.centre[i], s = cloud.scale[i];
        const Quat<float> q = cloud.rotation[i];
        places[i] = {x.x, x.y, x.z, cloud.opacity[i]};
        turns[i] = {q.x, q.y, q.z, q.w};
        scales[i] = {s.x, s.y, s.z, 0};
    }
    place = DeviceArray<float4>(places), turn = DeviceArray<float4>(turns);
    scale = DeviceArray<float4>(scales);
    sh = DeviceArray<uint4>(harmonics_rows(cloud));
    view.splats = {int(n), cloud.degree, place.data(), turn.data(), scale.data(), sh.data()};
}

void RasterStore::reserve(std::size_t instances)
{
    if (instances < 1 || instances > std::size_t(1) << 30)
        throw std::invalid_argument("splats: room for " + std::to_string(instances) +
                                    " instances; expected 1 to 2^30");
    for (int k = 0; k < 2; ++k) tiles[k] = {}, records[k] = {};
    for (int k = 0; k < 2; ++k) {
        tiles[k] = DeviceArray<std::uint16_t>(instances);
        records[k] = DeviceArray<int>(instances);
        view.tiles[k] = tiles[k].data(), view.records[k] = records[k].data();
    }
    view.room = int(instances);
    const std::size_t chunks = candidates_each * instances / chunk_size + 1;
    chunk_states = {};
    chunk_states = DeviceArray<unsigned long long>(chunks);
    view.chunks = int(chunks), view.chunk_states = chunk_states.data();
}

void RasterStore::resize(const SplatFrame& f)
{
    const Eye<float>& eye = f.eyes.at(0);
    const int columns = (eye.width + tile_size - 1) / tile_size;
    const int rows = (eye.height + tile_size - 1) / tile_size, eyes = int(f.eyes.size());
    if (f.eyes.back().width != eye.width || f.eyes.back().height != eye.height)
        throw std::invalid_argument("splats: eyes with pictures of different sizes");
    if (eyes * columns * rows > max_tiles)
        throw std::invalid_argument("splats: pictures of more than " + std::to_string(max_tiles) +
                                    " tiles of 16 x 16 pixels");
    view.eyes = eyes, view.columns = columns, view.rows = rows;
    view.width = eye.width, view.height = eye.height;
    ranges = {};
    ranges = DeviceArray<uint2>(std::size_t(view.all_tiles()));
    view.ranges = ranges.data();
}

std::size_t RasterStore::bytes() const
{
    std::size_t sum = 0;
    const auto add = [&](const auto&... arrays) { ((sum += arrays.bytes()), ...); };
    add(frame, counts, place, turn, scale, sh, depth_keys, sorted_keys, boxes, shapes, rests,
        numbers, order, records[0], records[1], candidate_starts, chunk_states, tiles[0], tiles[1],
        digit_counts, digit_starts, ranges, scratch_memory);
    return sum;
}

}  // namespace knead::gpu
