#include <algorithm>
#include <stdexcept>
#include <vector>

#include "cuda/device/device.cuh"
#include "cuda/device/device_array.cuh"
#include "cuda/device/graph.cuh"
#include "cuda/splats/raster.cuh"
#include "cuda/splats/spread.cuh"
#include "host/share/registered.cuh"
#include "host/share/shared_splats.h"
#include "host/splats/device_gaussians.cuh"

namespace knead {

using namespace gpu;

namespace {

// One eye's textures, and the picture, at most as large, that is copied to their first texels.
struct EyeShare {
    int width = 0, height = 0;
    Registered colour_texture, depth_texture;
    DeviceArray<uint2> colour;
    DeviceArray<float> depth, spare;
};

}  // namespace

struct SharedSplats::State {
    explicit State(int wanted) : device(chosen(wanted)), processors(multiprocessors(device)) {}

    MovedSplats moved(const SplatFrame& frame);
    void copy(const SplatFrame& frame);
    void time();

    int device, processors;
    Stream stream;
    EyeShare eye[2];
    DeviceArray<DepthSum> sum{1};
    // Positions and deformations of splats: staged in pinned memory until copied, and on the
    // device.
    std::unique_ptr<Pinned<float>> staged;
    DeviceArray<float> numbers;
    Event copied{cudaEventDisableTiming};
    Event from, to;
    bool timed = false;
    double seconds = 0;
};

SharedSplats::SharedSplats(int device) : state(std::make_unique<State>(device)) {}
// Pending work uses the memory freed here.
SharedSplats::~SharedSplats() { cudaStreamSynchronize(state->stream); }

void SharedSplats::take(int eye, unsigned colour, unsigned depth, int width, int height)
{
    check(cudaSetDevice(state->device), "device");
    wait(state->stream, "splats");
    EyeShare& e = state->eye[eye == 0 ? 0 : 1];
    e = {};
    const std::size_t pixels = std::size_t(width) * std::size_t(height);
    e.colour = DeviceArray<uint2>(pixels);
    e.depth = DeviceArray<float>(pixels), e.spare = DeviceArray<float>(pixels);
    e.colour_texture = Registered::texture(colour);
    e.depth_texture = Registered::texture(depth);
    e.width = width, e.height = height;
    state->timed = false, state->seconds = 0;
}

void SharedSplats::drop()
{
    check(cudaSetDevice(state->device), "device");
    wait(state->stream, "splats");
    for (EyeShare& e : state->eye) e = {};
}

// Uploads the frame's deformations; allocates only if the number of splats has grown.
MovedSplats SharedSplats::State::moved(const SplatFrame& frame)
{
    const std::size_t n = frame.moved_centre.size(), each = 12;
    if (frame.moved_F.size() != n)
        throw std::invalid_argument("splats: expected a deformation for each moved splat");
    if (n == 0) return {};
    wait(copied, "splats");
    if (!staged || staged->size() < each * n) {
        staged = std::make_unique<Pinned<float>>(each * n);
        numbers = {}, numbers = DeviceArray<float>(each * n);
    }
    float* at = staged->data();
    for (std::size_t i = 0; i < n; ++i) {
        const Mat3<float>& F = frame.moved_F[i];
        for (const Vec3<float>& v : {frame.moved_centre[i], F.a, F.b, F.c})
            *at++ = v.x, *at++ = v.y, *at++ = v.z;
    }
    check(cudaMemcpyAsync(numbers.data(), staged->data(), each * n * sizeof(float),
                          cudaMemcpyDefault, stream),
          "splats");
    check(cudaEventRecord(copied, stream), "splats");
    return {int(n), numbers.data(), int(each), numbers.data() + 3, int(each)};
}

void SharedSplats::State::copy(const SplatFrame& frame)
{
    const int eyes = int(frame.eyes.size());
    cudaGraphicsResource_t resources[4];
    for (int e = 0; e < eyes; ++e) {
        resources[2 * e] = eye[e].colour_texture;
        resources[2 * e + 1] = eye[e].depth_texture;
    }
    Mapped mapped(resources, 2 * eyes, stream);
    const auto put = [&](cudaGraphicsResource_t to, const void* picture, std::size_t row,
                         int rows) {
        cudaArray_t array;
        check(cudaGraphicsSubResourceGetMappedArray(&array, to, 0, 0), "sharing with OpenGL");
        check(cudaMemcpy2DToArrayAsync(array, 0, 0, picture, row, row, std::size_t(rows),
                                       cudaMemcpyDeviceToDevice, stream),
              "sharing with OpenGL");
    };
    for (int e = 0; e < eyes; ++e) {
        const EyeShare& s = eye[e];
        const Eye<float>& seen = frame.eyes[std::size_t(e)];
        const auto width = std::size_t(seen.width);
        put(s.colour_texture, s.colour.data(), width * sizeof(uint2), seen.height);
        put(s.depth_texture, s.depth.data(), width * sizeof(float), seen.height);
    }
    mapped.end();
}

// Reads the last picture's time if its events have completed, and starts timing this one.
void SharedSplats::State::time()
{
    if (!timed) {
        check(cudaEventRecord(from, stream), "splats");
        return;
    }
    if (!is_over(to, "splats")) return;
    float milliseconds = 0;
    check(cudaEventElapsedTime(&milliseconds, from, to), "splats");
    seconds = 1e-3 * double(milliseconds);
    timed = false;
    check(cudaEventRecord(from, stream), "splats");
}

void SharedSplats::draw(GpuRaster& raster, const SplatFrame& frame, const DeviceGaussians* moved)
{
    const int eyes = int(frame.eyes.size());
    RasterTarget targets[2]{};
    for (int e = 0; e < std::min(eyes, 2); ++e) {
        const EyeShare& s = state->eye[e];
        const Eye<float>& seen = frame.eyes[std::size_t(e)];
        if (s.width < seen.width || s.height < seen.height)
            throw std::invalid_argument("splats: an eye larger than its textures");
        targets[e] = {nullptr, nullptr, s.colour.data(), s.depth.data()};
    }
    check(cudaSetDevice(state->device), "device");
    state->time();
    if (moved) moved->kept().wait(state->stream);
    if (moved && moved->before()) moved->before()->wait(state->stream);
    const MovedSplats as =
        moved ? moved->kept().moved(moved->before(), frame.extrapolation) : state->moved(frame);
    raster.launch(frame, &as, targets, cudaStream_t(state->stream));
    if (moved) moved->kept().done(state->stream);
    if (moved && moved->before()) moved->before()->done(state->stream);
    for (int e = 0; e < eyes; ++e) {
        const EyeShare& s = state->eye[e];
        const Eye<float>& seen = frame.eyes[std::size_t(e)];
        spread({seen.width, seen.height, s.colour.data(), s.depth.data(), s.spare.data(),
                state->sum.data()},
               state->processors, state->stream);
    }
    if (!state->timed) check(cudaEventRecord(state->to, state->stream), "splats");
    state->timed = true;
    state->copy(frame);
}

double SharedSplats::seconds() const { return state->seconds; }

}  // namespace knead
