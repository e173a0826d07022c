// Timings of a surface on the device: of its graph and of single stages.
#include <algorithm>

#include "cuda/device/device.cuh"
#include "host/surface/gpu_surface.h"
#include "host/surface/gpu_surface_state.cuh"

namespace knead {

using namespace gpu;

double GpuSurface::State::seconds_of(cudaGraphExec_t what)
{
    if (what == graph.ready) apply_resets(stream);
    check(cudaEventRecord(from, stream), "surface");
    check(cudaGraphLaunch(what, stream), "surface");
    check(cudaEventRecord(to, stream), "surface");
    check(cudaEventSynchronize(to), "surface");
    float milliseconds = 0;
    check(cudaEventElapsedTime(&milliseconds, from, to), "surface");
    return 1e-3 * double(milliseconds);
}

std::vector<double> GpuSurface::replays(int count)
{
    std::vector<double> seconds;
    for (int k = 0; k < count && state->graph.ready; ++k)
        seconds.push_back(state->seconds_of(state->graph.ready));
    return seconds;
}

std::vector<StageTime> GpuSurface::stage_times()
{
    constexpr int copies = 20, repeats = 11;
    std::vector<StageTime> times;
    if (!state->graph.ready) return times;
    for (const SurfaceStage& stage : state->stages(state->clay)) {
        state->fresh = true;
        state->run();
        Graph alone;
        alone.begin(state->stream);
        for (int k = 0; k < copies; ++k) stage.launch(state->stream);
        alone.end(state->stream);
        std::vector<double> seconds;
        for (int k = 0; k < repeats; ++k) seconds.push_back(state->seconds_of(alone.ready));
        std::nth_element(seconds.begin(), seconds.begin() + repeats / 2, seconds.end());
        times.push_back({stage.name, seconds[repeats / 2] / copies});
    }
    state->fresh = true;
    state->run();
    return times;
}

std::vector<StageWork> GpuSurface::stage_counts()
{
    if (!state->graph.ready) return {};
    check(cudaSetDevice(state->device), "device");
    const std::vector<StageWork> counts = counted([this](const StageObserver& watch) {
        for (const SurfaceStage& stage : state->stages(state->clay)) {
            state->fresh = true;
            state->run();
            watch(stage.name,
                  [&] { stage.launch(state->stream), wait(state->stream, stage.name); });
        }
    });
    state->fresh = true;
    state->run();
    return counts;
}

}  // namespace knead
