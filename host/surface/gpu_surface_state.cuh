// State of a surface on the device, and the order of its stages.
#pragma once
#include <functional>
#include <memory>
#include <vector>

#include "cuda/device/graph.cuh"
#include "host/surface/device_mesh.cuh"
#include "host/surface/gpu_surface_store.cuh"

namespace knead {

struct SurfaceStage {
    const char* name;
    std::function<void(cudaStream_t)> launch;
};

struct GpuSurface::State {
    int device, processors;
    bool fixed_room;
    gpu::SurfaceStore store;
    gpu::Stream stream;
    gpu::Event from, to;

    // Input of the last surface.
    gpu::DeviceArray<float4> rows;
    gpu::Clay clay{};
    gpu::Graph graph;
    bool fresh = true;           // recompute everything
    bool skips_advance = false;  // no motion for the next surface
    gpu::KeptMeshes kept;
    std::shared_ptr<gpu::KeptMesh> under_way;  // launched by launch_kept(); null: none

    State(const std::vector<Particle<double>>& particles,
          const std::vector<Material<double>>& materials, const SurfaceOptions& options,
          SurfaceRoom room, int wanted);
    std::vector<SurfaceStage> stages(const gpu::Clay& now) const;
    bool set_materials(const std::vector<Material<double>>& materials);
    void prepare(const gpu::Clay& now);
    void apply_resets(cudaStream_t on);
    void start(cudaStream_t on);
    void run();
    SurfaceRoom needed() const;
    void make(const gpu::Clay& now);
    double seconds_of(cudaGraphExec_t what);
    gpu::Clay uploaded(const std::vector<Particle<double>>& particles);
    gpu::Amounts before_block(int block) const;
    SurfaceRoom room() const;
    bool fits(const SurfaceRoom& needs) const;
    void take_room(const SurfaceRoom& needs);
    SurfaceStats settled(const SurfaceRoom& needs, const gpu::SurfaceErrors& errors) const;
    void launch_kept(const gpu::Clay& now, cudaStream_t on);
    std::shared_ptr<const DeviceMesh> launched(SurfaceStats* stats);
};

}  // namespace knead
