// What a GpuRaster has.
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
    bool with_mesh = false;  // as the graph was captured
    int with_moved = 0;
    // What the last frame that was asked needed, once `told` is there.
    gpu::Pinned<gpu::RasterCounts> needed;
    gpu::Event told{cudaEventDisableTiming};
    gpu::Event launched{cudaEventDisableTiming};  // the last frame of launch(), on whatever stream
    bool asked = false;
    // What pictures() draws from and to.
    gpu::DeviceArray<uint2> colour[2], mesh_colour[2];
    gpu::DeviceArray<float> depth[2], mesh_depth[2], moved_numbers;
    std::vector<char> hidden;  // squares, as the device has them; empty: all is seen
    gpu::DeviceArray<char> hidden_squares;
    bool resized = true;  // since hide()
};

}  // namespace knead
