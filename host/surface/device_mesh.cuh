// The device memory of a mesh that is kept.
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
    Pinned<MeshInfo> told;  // the same on the host, once it is written
    Event written{cudaEventDisableTiming};
    // After the last read of it that was launched and not waited for: whoever writes again waits.
    Event read{cudaEventDisableTiming};
};

// Meshes of one surface, one after the other, in memory that nobody reads any more.
class KeptMeshes {
  public:
    // Launches the copy behind the surface on the stream, and waits for nothing.
    std::shared_ptr<KeptMesh> launch(const SurfaceView& view, int device, cudaStream_t stream);
    std::size_t bytes() const;

  private:
    std::vector<std::shared_ptr<KeptMesh>> all;
};

}  // namespace knead::gpu
