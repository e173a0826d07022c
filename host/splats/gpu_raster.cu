#include <cuda_fp16.h>

#include <algorithm>
#include <stdexcept>

#include "cuda/device/device.cuh"
#include "cuda/device/graph.cuh"
#include "host/splats/gpu_raster_state.cuh"
#include "host/splats/prepared.h"

namespace knead {

using namespace gpu;

namespace {

uint2 to_halves(Vec3<float> c, float a)
{
    const auto bits = [](float x) { return unsigned(__half_as_ushort(__float2half_rn(x))); };
    return {bits(c.x) | bits(c.y) << 16, bits(c.z) | bits(a) << 16};
}
float from_half(unsigned bits)
{
    return __half2float(__ushort_as_half((unsigned short)(bits & 0xffff)));
}

// Initial capacity, before the count of a scene is known.
std::size_t first_room(const RasterView& view)
{
    return std::clamp(8 * std::size_t(view.count), std::size_t(1) << 16, std::size_t(1) << 25);
}

}  // namespace

GpuRaster::State::State(const SplatCloud& cloud, std::size_t instances, int wanted,
                        std::size_t splats)
    : device(chosen(wanted)),
      fixed_room(instances != 0),
      store(std::max(cloud.count(), splats), cloud.degree)
{
    table.fill(cloud, std::size_t(store.view.count), stream);
    store.reserve(instances ? instances : first_room(store.view));
}

std::vector<RasterStage> GpuRaster::State::stages(bool mesh, int moved) const
{
    const RasterView d = store.view;
    const RasterScratch s = store.scratch;
    return {{"project", [=](cudaStream_t on) { gpu::project(d, moved, on); }},
            {"sort", [=](cudaStream_t on) { sort_by_depth(d, s, on); }},
            {"scan", [=](cudaStream_t on) { scan_candidates(d, s, on); }},
            {"emit", [=](cudaStream_t on) { emit(d, on); }},
            {"sort by tile", [=](cudaStream_t on) { sort_by_tile(d, s, on); }},
            {"blend", [=](cudaStream_t on) { gpu::blend(d, mesh, on); }}};
}

// Captures the graph for frames of this shape. The number of moved splats is rounded up, so that
// small changes do not recapture it.
void GpuRaster::State::prepare(const SplatFrame& frame, bool mesh, int moved)
{
    constexpr int step = 1 << 14;
    const RasterView& d = store.view;
    if (moved > 0) moved = std::min((moved + step - 1) / step * step, d.count);
    const bool same_size = d.eyes == int(frame.eyes.size()) && d.width == frame.eyes[0].width &&
                           d.height == frame.eyes[0].height && frame.eyes.back().width == d.width &&
                           frame.eyes.back().height == d.height;
    if (graph.ready && same_size && mesh == with_mesh && moved == with_moved) return;
    graph.drop();
    if (!same_size) store.resize(frame), resized = true;
    with_mesh = mesh, with_moved = moved;
    graph.begin(stream);
    for (const RasterStage& stage : stages(mesh, moved)) stage.launch(stream);
    graph.end(stream);
}

RasterFrame GpuRaster::State::described(const SplatFrame& frame, const MovedSplats& moved,
                                        const RasterTarget* targets) const
{
    RasterFrame f{};
    f.splats = table.view();
    for (std::size_t e = 0; e < frame.eyes.size(); ++e) {
        f.camera[e] = pinhole(frame.eyes[e]);
        f.target[e] = targets[e];
        if (!frame.fovea.empty()) f.fovea[e] = frame.fovea[e];
    }
    f.middle = cast<float>(middle_of(frame));
    f.options = frame.options, f.background = frame.background, f.moved = moved;
    f.hidden = hidden.empty() ? nullptr : hidden_squares.data();
    return f;
}

// Uploads the hidden tiles if they or the size have changed, after the previous frame on the
// stream. After a change of size the statistics of all tiles are reset.
void GpuRaster::State::hide(const SplatFrame& frame, cudaStream_t on)
{
    static_assert(square_size == hidden_tile);
    const RasterView& d = store.view;
    const std::ptrdiff_t of_eye = d.square_columns() * d.square_rows();
    std::vector<char> squares;
    for (std::size_t e = 0; e < frame.hidden.size(); ++e) {
        if (frame.hidden[e].empty()) continue;
        squares.resize(std::size_t(d.all_squares()), 0);
        std::copy(frame.hidden[e].begin(), frame.hidden[e].end(),
                  squares.begin() + std::ptrdiff_t(e) * of_eye);
    }
    if (!resized && squares == hidden) return;
    if (resized)
        check(cudaMemsetAsync(d.samples, 0, std::size_t(d.all_tiles()) * sizeof *d.samples, on),
              "splats");
    resized = false, hidden = std::move(squares);
    const std::vector<unsigned char> seen = seen_parts(d, hidden);
    check(cudaMemcpyAsync(store.seen_parts_of.data(), seen.data(), seen.size(), cudaMemcpyDefault,
                          on),
          "splats");
    if (hidden.empty()) return;
    if (hidden_squares.size() == 0) hidden_squares = DeviceArray<char>(max_squares);
    check(
        cudaMemcpyAsync(hidden_squares.data(), hidden.data(), hidden.size(), cudaMemcpyDefault, on),
        "splats");
}

void GpuRaster::State::start(const RasterFrame& frame, cudaStream_t on)
{
    const ProfilerRange range{"splats"};
    set_frame(store.frame.data(), frame, on);
    check(cudaGraphLaunch(graph.ready, on), "splats");
}

// Enqueues the download of the capacity that a frame of launch() needed; does not block.
void GpuRaster::State::ask_room(cudaStream_t on)
{
    if (fixed_room || pending) return;
    check(cudaMemcpyAsync(needed.data(), store.counts.data(), sizeof(RasterCounts),
                          cudaMemcpyDefault, on),
          "splats");
    check(cudaEventRecord(copied, on), "splats");
    pending = true;
}
void GpuRaster::State::make_room()
{
    if (!pending || !is_over(copied, "splats")) return;
    pending = false;
    const std::size_t wanted = std::size_t(needed->instances);
    if (wanted <= std::size_t(store.view.room)) return;
    graph.drop();
    store.reserve(std::min(wanted + wanted / 2, std::size_t(1) << 30));
}

// Draws into `colour` and `depth`; blocks.
void GpuRaster::State::take_pictures(const SplatFrame& frame)
{
    const std::size_t n = frame.moved_centre.size();
    check_moved(n);
    bool mesh = false;
    for (const Backdrop& b : frame.behind) mesh |= !b.depth.empty();
    RasterTarget targets[2]{};
    for (std::size_t e = 0; e < frame.eyes.size(); ++e) {
        const std::size_t pixels =
            std::size_t(frame.eyes[e].width) * std::size_t(frame.eyes[e].height);
        if (colour[e].size() != pixels) {
            colour[e] = {}, depth[e] = {};
            colour[e] = DeviceArray<uint2>(pixels), depth[e] = DeviceArray<float>(pixels);
        }
        targets[e] = {nullptr, nullptr, colour[e].data(), depth[e].data()};
        if (!mesh) continue;
        std::vector<uint2> behind(pixels);
        std::vector<float> depths(pixels, no_depth);
        if (const Backdrop& b = frame.behind[e]; !b.depth.empty()) {
            depths = b.depth;
            for (std::size_t i = 0; i < pixels; ++i) behind[i] = to_halves(b.colour[i], 1);
        }
        mesh_colour[e] = DeviceArray<uint2>(behind), mesh_depth[e] = DeviceArray<float>(depths);
        targets[e].mesh_colour = mesh_colour[e].data(),
        targets[e].mesh_depth = mesh_depth[e].data();
    }
    MovedSplats moved{};
    if (n > 0) {
        static_assert(sizeof(Mat3<float>) == 9 * sizeof(float));
        std::vector<float> numbers;
        for (std::size_t i = 0; i < n; ++i) {
            const Vec3<float> x = frame.moved_centre[i];
            const Mat3<float>& F = frame.moved_F[i];
            for (const Vec3<float>& v : {x, F.a, F.b, F.c})
                numbers.insert(numbers.end(), {v.x, v.y, v.z});
        }
        moved_numbers = {};
        moved_numbers = DeviceArray<float>(numbers);
        moved = {int(n), moved_numbers.data(), 12, moved_numbers.data() + 3, 12};
    }
    prepare(frame, mesh, int(n));
    check(cudaStreamWaitEvent(stream, launched, 0), "splats");
    hide(frame, stream);
    start(described(frame, moved, targets), stream);
    wait(stream, "splats");
}

GpuRaster::GpuRaster(const SplatCloud& cloud, std::size_t instances, int device, std::size_t splats)
    : state(std::make_unique<State>(cloud, instances, device, splats))
{
}
GpuRaster::~GpuRaster() = default;

bool GpuRaster::serves(const SplatCloud& cloud) const
{
    return cloud.degree == state->store.view.degree &&
           cloud.count() <= std::size_t(state->store.view.count);
}

// Waits for the frames that read the previous buffer, which were launched before it was swapped
// out.
void GpuRaster::prepare(const SplatCloud& cloud)
{
    if (!serves(cloud)) throw std::invalid_argument("splats: the capacity is exceeded");
    check(cudaSetDevice(state->device), "device");
    check(cudaStreamWaitEvent(state->loading, state->launched, 0), "splats");
    state->prepared.fill(cloud, std::size_t(state->store.view.count), state->loading);
}

void GpuRaster::show_prepared() { std::swap(state->table, state->prepared); }

void GpuRaster::reserve(std::size_t instances)
{
    if (instances <= room()) return;
    state->graph.drop();
    state->store.reserve(instances);
}

std::vector<Picture> GpuRaster::pictures(const SplatFrame& frame)
{
    check_frame(SplatCloud{}, [&] {
        SplatFrame still = frame;
        still.moved_centre.clear(), still.moved_F.clear();
        return still;
    }());
    if (frame.moved_centre.size() != frame.moved_F.size())
        throw std::invalid_argument("splats: expected a deformation for each moved splat");
    check(cudaSetDevice(state->device), "device");
    state->take_pictures(frame);
    const std::size_t needed = state->stats().instances;
    if (!state->fixed_room && needed > room()) {
        state->graph.drop();
        state->store.reserve(needed + needed / 2);
        state->take_pictures(frame);
    }
    std::vector<Picture> pictures;
    for (std::size_t e = 0; e < frame.eyes.size(); ++e) {
        const std::vector<uint2> colours = state->colour[e].downloaded();
        Picture p{frame.eyes[e].width, frame.eyes[e].height, {}, {}, state->depth[e].downloaded()};
        for (const uint2 c : colours) {
            p.colour.push_back({from_half(c.x), from_half(c.x >> 16), from_half(c.y)});
            p.alpha.push_back(from_half(c.y >> 16));
        }
        pictures.push_back(std::move(p));
    }
    return pictures;
}

void GpuRaster::launch(const SplatFrame& frame, const MovedSplats* moved,
                       const RasterTarget* targets, void* stream)
{
    SplatFrame shape;
    shape.eyes = frame.eyes, shape.options = frame.options, shape.hidden = frame.hidden;
    shape.fovea = frame.fovea;
    check_frame(SplatCloud{}, shape);
    check(cudaSetDevice(state->device), "device");
    const MovedSplats still{};
    const MovedSplats& m = moved ? *moved : still;
    state->check_moved(std::size_t(m.count));
    state->make_room();
    state->prepare(frame, targets[0].mesh_depth != nullptr, m.count);
    const auto on = static_cast<cudaStream_t>(stream);
    check(cudaStreamWaitEvent(on, state->launched, 0), "splats");
    state->hide(frame, on);
    state->start(state->described(frame, m, targets), on);
    state->ask_room(on);
    check(cudaEventRecord(state->launched, on), "splats");
}

int GpuRaster::device() const { return state->device; }

RasterStats GpuRaster::stats() const { return state->stats(); }

std::size_t GpuRaster::room() const { return std::size_t(state->store.view.room); }

}  // namespace knead
