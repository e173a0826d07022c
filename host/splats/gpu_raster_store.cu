#include <cuda_fp16.h>

#include <numeric>
#include <stdexcept>
#include <string>

#include "host/splats/gpu_raster_store.cuh"

namespace knead::gpu {
namespace {

// The range of a half is 65504; non-finite values stay non-finite and are drawn black.
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

// Capacity for candidates per instance.
constexpr std::size_t candidates_each = 8;

RasterStore::RasterStore(std::size_t n, int degree)
{
    view.count = int(n), view.degree = degree;
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
    seen_parts_of = DeviceArray<unsigned char>(max_tiles);
    samples = DeviceArray<TileSample>(max_tiles), rules = DeviceArray<TileOptions>(max_tiles);
    view.seen_parts = seen_parts_of.data();
    view.samples = samples.data(), view.rules = rules.data();
    deferred = DeviceArray<int>(max_tiles * parts), view.deferred = deferred.data();
    digit_counts = DeviceArray<unsigned>(digit_table_size);
    digit_starts = DeviceArray<unsigned>(digit_table_size);
    view.digit_counts = digit_counts.data(), view.digit_starts = digit_starts.data();
    scratch_memory = DeviceArray<unsigned char>(raster_scratch_bytes(view.count));
    scratch = {scratch_memory.data(), scratch_memory.bytes()};
}

// Waits only for the copies.
void SplatTable::fill(const SplatCloud& cloud, std::size_t room, cudaStream_t stream)
{
    SplatFrame any;
    any.eyes = {{{0, 0, 0}, {1, 0, 0, 0}, -1, 1, -1, 1, 1, 1}};
    check_frame(cloud, any);
    const std::size_t n = cloud.count();
    std::vector<float4> places(n), turns(n), scales(n);
    for (std::size_t i = 0; i < n; ++i) {
        const Vec3<float> x = cloud.centre[i], s = cloud.scale[i];
        const Quat<float> q = cloud.rotation[i];
        places[i] = {x.x, x.y, x.z, cloud.opacity[i]};
        turns[i] = {q.x, q.y, q.z, q.w};
        scales[i] = {s.x, s.y, s.z, 0};
    }
    const auto put = [&](auto& to, const auto& from, std::size_t each) {
        using Array = std::remove_reference_t<decltype(to)>;
        if (to.size() < each * room) to = Array(each * room);
        if (from.empty()) return;
        check(cudaMemcpyAsync(to.data(), from.data(), from.size() * sizeof from[0],
                              cudaMemcpyDefault, stream),
              "splats");
    };
    put(place, places, 1), put(turn, turns, 1), put(scale, scales, 1);
    const std::vector<uint4> rows = harmonics_rows(cloud);
    put(sh, rows, std::size_t(sh_row(cloud.degree)));
    wait(stream, "splats");
    seen = {int(n), cloud.degree, place.data(), turn.data(), scale.data(), sh.data()};
}

std::size_t SplatTable::bytes() const
{
    return place.bytes() + turn.bytes() + scale.bytes() + sh.bytes();
}

void RasterStore::reserve(std::size_t instances)
{
    if (instances < 1 || instances > std::size_t(1) << 30)
        throw std::invalid_argument("splats: room for " + std::to_string(instances) +
                                    " instances; expected 1 to 2^30");
    for (int k = 0; k < 2; ++k) keys[k] = {}, records[k] = {};
    for (int k = 0; k < 2; ++k) {
        keys[k] = DeviceArray<std::uint16_t>(instances);
        records[k] = DeviceArray<int>(instances);
        view.keys[k] = keys[k].data(), view.records[k] = records[k].data();
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
    RasterView seen = view;
    seen.eyes = eyes, seen.columns = columns, seen.rows = rows;
    seen.width = eye.width, seen.height = eye.height;
    if (seen.all_squares() > max_squares)
        throw std::invalid_argument("splats: pictures of more than " + std::to_string(max_squares) +
                                    " tiles of 16 x 16 pixels");
    view = seen;
    if (const auto lists = std::size_t(view.all_keys()); ranges.size() < lists) {
        ranges = {};
        ranges = DeviceArray<uint2>(lists);
    }
    view.ranges = ranges.data();
}

std::vector<unsigned char> seen_parts(const RasterView& d, const std::vector<char>& hidden)
{
    constexpr int each = tile_size / square_size;
    const int across = d.square_columns(), down = d.square_rows();
    std::vector<unsigned char> seen(std::size_t(d.all_tiles()));
    for (int n = 0; n < d.all_squares(); ++n) {
        if (!hidden.empty() && hidden[std::size_t(n)]) continue;
        const int rows = n / across, e = rows / down;  // row index over both eyes
        const int x = n - rows * across, y = rows - e * down;
        const int part = y % each / (part_height / square_size) * parts_across +
                         x % each / (part_width / square_size);
        seen[std::size_t((e * d.rows + y / each) * d.columns + x / each)] |=
            (unsigned char)(1 << part);
    }
    return seen;
}

std::size_t RasterStore::bytes() const
{
    std::size_t sum = 0;
    const auto add = [&](const auto&... arrays) { ((sum += arrays.bytes()), ...); };
    add(frame, counts, depth_keys, sorted_keys, boxes, shapes, rests, numbers, order, records[0],
        records[1], candidate_starts, chunk_states, keys[0], keys[1], digit_counts, digit_starts,
        ranges, seen_parts_of, samples, rules, deferred, scratch_memory);
    return sum;
}

}  // namespace knead::gpu
