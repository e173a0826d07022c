// State of a GpuRaster.
#pragma once
#include <functional>
#include <stdexcept>
#include <vector>

#include "cuda/device/graph.cuh"
#include "host/splats/gpu_raster.h"
#include "host/splats/gpu_raster_store.cuh"

namespace knead {

struct RasterStage {
    const char* name;
    std::function<void(cudaStream_t)> launch;
};

struct GpuRaster::State {
    State(const SplatCloud& cloud, std::size_t instances, int wanted, std::size_t splats);

    void check_moved(std::size_t moved) const
    {
        if (moved > std::size_t(table.view().count))
            throw std::invalid_argument("splats: more splats moved than there are");
    }
    std::vector<RasterStage> stages(bool mesh, int moved) const;
    void prepare(const SplatFrame& frame, bool mesh, int moved);
    gpu::RasterFrame described(const SplatFrame& frame, const gpu::MovedSplats& moved,
                               const gpu::RasterTarget* targets) const;
    void hide(const SplatFrame& frame, cudaStream_t on);
    void start(const gpu::RasterFrame& frame, cudaStream_t on);
    void ask_room(cudaStream_t on);
    void make_room();
    double seconds_of(cudaGraphExec_t what);
    RasterStats stats() const;
    void take_pictures(const SplatFrame& frame);

    int device;
    bool fixed_room;
    gpu::Stream stream, loading;
    gpu::SplatTable table, prepared;
    gpu::RasterStore store;
    gpu::Event from, to;
    gpu::Graph graph;
    bool with_mesh = false;  // of the captured graph
    int with_moved = 0;
    // Counts of the last polled frame, valid once `copied` has completed.
    gpu::Pinned<gpu::RasterCounts> needed;
    gpu::Event copied{cudaEventDisableTiming};
    gpu::Event launched{cudaEventDisableTiming};  // after the last frame of launch(), on any stream
    bool pending = false;
    // Inputs and outputs of pictures().
    gpu::DeviceArray<uint2> colour[2], mesh_colour[2];
    gpu::DeviceArray<float> depth[2], mesh_depth[2], moved_numbers;
    std::vector<char> hidden;  // per square, as on the device; empty: none is hidden
    gpu::DeviceArray<char> hidden_squares;
    bool resized = true;  // since the last hide()
};

}  // namespace knead
