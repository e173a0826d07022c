// Timings, counts and device memory of the rasteriser.
#include <algorithm>

#include "cuda/device/device.cuh"
#include "host/splats/gpu_raster_state.cuh"

namespace knead {

using namespace gpu;

double GpuRaster::State::seconds_of(cudaGraphExec_t what)
{
    check(cudaEventRecord(from, stream), "splats");
    check(cudaGraphLaunch(what, stream), "splats");
    check(cudaEventRecord(to, stream), "splats");
    check(cudaEventSynchronize(to), "splats");
    float milliseconds = 0;
    check(cudaEventElapsedTime(&milliseconds, from, to), "splats");
    return 1e-3 * double(milliseconds);
}

RasterStats GpuRaster::State::stats() const
{
    wait(launched, "splats"), wait(stream, "splats");
    const RasterCounts c = store.counts.downloaded().at(0);
    return {c.visible, std::size_t(c.instances), std::size_t(c.dropped), std::size_t(c.deferred)};
}

std::vector<double> GpuRaster::replays(int count)
{
    std::vector<double> seconds;
    for (int k = 0; k < count && state->graph.ready; ++k)
        seconds.push_back(state->seconds_of(state->graph.ready));
    return seconds;
}

// Events between the stages of one graph, so that each stage runs with the cache contents of a real
// frame.
std::vector<StageTime> GpuRaster::stage_times()
{
    constexpr std::size_t repeats = 21;
    if (!state->graph.ready) return {};
    const std::vector<RasterStage> stages = state->stages(state->with_mesh, state->with_moved);
    std::vector<Event> marks(stages.size() + 1);
    Graph marked;
    const auto mark = [&](const Event& event) {
        check(cudaEventRecordWithFlags(event, state->stream, cudaEventRecordExternal), "splats");
    };
    marked.begin(state->stream);
    for (std::size_t k = 0; k < stages.size(); ++k) {
        mark(marks[k]);
        stages[k].launch(state->stream);
    }
    mark(marks.back());
    marked.end(state->stream);
    std::vector<std::vector<double>> seconds(stages.size());
    for (std::size_t repeat = 0; repeat < repeats; ++repeat) {
        state->seconds_of(marked.ready);
        for (std::size_t k = 0; k < stages.size(); ++k) {
            float milliseconds = 0;
            check(cudaEventElapsedTime(&milliseconds, marks[k], marks[k + 1]), "splats");
            seconds[k].push_back(1e-3 * double(milliseconds));
        }
    }
    std::vector<StageTime> times;
    for (std::size_t k = 0; k < stages.size(); ++k) {
        std::nth_element(seconds[k].begin(), seconds[k].begin() + repeats / 2, seconds[k].end());
        times.push_back({stages[k].name, seconds[k][repeats / 2]});
    }
    return times;
}

std::size_t GpuRaster::memory() const
{
    std::size_t sum = state->store.bytes() + state->hidden_squares.bytes() + state->table.bytes() +
                      state->prepared.bytes() + state->moved_numbers.bytes();
    for (int e = 0; e < 2; ++e)
        sum += state->colour[e].bytes() + state->depth[e].bytes() + state->mesh_colour[e].bytes() +
               state->mesh_depth[e].bytes();
    return sum;
}

}  // namespace knead
