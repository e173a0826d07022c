// A surface's mesh that stays on the device where it was made.
#pragma once
#include <memory>
#include <vector>

#include "host/surface/mesh.h"

namespace knead {
namespace gpu {
struct KeptMesh;  // host/surface/device_mesh.cuh
struct MeshInfo;  // cuda/surface/kept_mesh.cuh
}  // namespace gpu

// What fits into the device's buffers.
struct SurfaceRoom {
    std::size_t vertices = 0, triangles = 0;  // 0: as many as the clay should need
};

// Never changes. May be read by any thread, and let go of by any.
class DeviceMesh {
  public:
    DeviceMesh(std::shared_ptr<gpu::KeptMesh> kept, std::vector<int> categories,
               const gpu::MeshInfo& facts);

    int device() const;
    bool empty() const { return triangles_ == 0; }
    std::size_t vertices() const { return vertices_; }
    std::size_t triangles() const { return triangles_; }
    // The box about all vertices [m]; of an empty mesh without meaning.
    Vec3<float> low() const { return low_; }
    Vec3<float> high() const { return high_; }
    // Of which the parts are, rising; some may be empty.
    const std::vector<int>& categories() const { return categories_; }
    SurfaceRoom room() const;  // of its buffers: at least what there is

    // The same on the host, without parts that are empty. Waits. Throws std::runtime_error where
    // the device fails.
    std::vector<Mesh> meshes() const;

    gpu::KeptMesh& kept() const { return *kept_; }

  private:
    std::shared_ptr<gpu::KeptMesh> kept_;
    std::vector<int> categories_;
    std::size_t vertices_ = 0, triangles_ = 0;
    Vec3<float> low_{}, high_{};
};

}  // namespace knead
