// Device memory of a kept mesh.
#pragma once
#include "cuda/device/device_array.cuh"
#include "cuda/device/graph.cuh"
#include "cuda/surface/kept_mesh.cuh"
#include "host/surface/device_mesh.h"

namespace knead::gpu {

struct KeptMesh {
    KeptMesh(SurfaceRoom room, int categories, int device);
    MeshPlace place() const
    {
        return {triangles.data(), places.data(), normals.data(), draws.data(), facts.data()};
    }

    int device, processors;
    DeviceArray<Int3> triangles;
    DeviceArray<float4> places, normals;
    DeviceArray<DrawCommand> draws;
    DeviceArray<MeshInfo> facts;
    Pinned<MeshInfo> host_info;  // host copy of `facts`, valid after `written`
    Event written{cudaEventDisableTiming};
    // After the last launched read; a writer waits for it.
    Event read{cudaEventDisableTiming};
};

// Pool of the kept meshes of one surface; released memory is reused.
class KeptMeshes {
  public:
    // Enqueues the copy after the surface on the stream; does not block.
    std::shared_ptr<KeptMesh> launch(const SurfaceView& view, int device, cudaStream_t stream);
    std::size_t bytes() const;

  private:
    std::vector<std::shared_ptr<KeptMesh>> all;
};

}  // namespace knead::gpu
