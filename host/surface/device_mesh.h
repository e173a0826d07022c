// The mesh of a surface, kept in device memory.
#pragma once
#include <memory>
#include <vector>

#include "cuda/math/box.h"
#include "host/surface/mesh.h"

namespace knead {
namespace gpu {
struct KeptMesh;  // host/surface/device_mesh.cuh
struct MeshInfo;  // cuda/surface/kept_mesh.cuh
}  // namespace gpu

// Capacity of the device buffers.
struct SurfaceRoom {
    std::size_t vertices = 0, triangles = 0;  // 0: estimated from the amount of clay
};

// Immutable. Thread-safe, including destruction.
class DeviceMesh {
  public:
    DeviceMesh(std::shared_ptr<gpu::KeptMesh> kept, std::vector<int> categories,
               const gpu::MeshInfo& facts);

    int device() const;
    bool empty() const { return triangles_ == 0; }
    std::size_t vertices() const { return vertices_; }
    std::size_t triangles() const { return triangles_; }
    // Bounding box of all vertices [m]; undefined for an empty mesh.
    const Box3<float>& box() const { return box_; }
    // Categories of the parts, ascending; some parts may be empty.
    const std::vector<int>& categories() const { return categories_; }
    SurfaceRoom room() const;  // capacity of the buffers

    // Downloads the mesh, without empty parts. Blocks. Throws std::runtime_error on device errors.
    std::vector<Mesh> meshes() const;

    gpu::KeptMesh& kept() const { return *kept_; }

  private:
    std::shared_ptr<gpu::KeptMesh> kept_;
    std::vector<int> categories_;
    std::size_t vertices_ = 0, triangles_ = 0;
    Box3<float> box_{};
};

}  // namespace knead
