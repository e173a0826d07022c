// An OpenGL buffer that receives meshes from a CUDA device without a copy through host memory.
#pragma once
#include <memory>

#include "host/surface/device_mesh.h"

namespace knead {

// Byte offsets of the parts of a mesh in one buffer: three 32-bit indices per triangle, four floats
// per vertex for the position and four for the normal, and five 32-bit words per category, the
// command of glDrawElementsIndirect.
struct MeshLayout {
    MeshLayout() = default;
    MeshLayout(SurfaceRoom for_room, std::size_t categories)
        : room(for_room),
          places(aligned(12 * room.triangles)),
          normals(places + aligned(16 * room.vertices)),
          draws(normals + aligned(16 * room.vertices)),
          bytes(draws + aligned(command * categories))
    {
    }
    static constexpr std::size_t command = 20;

    SurfaceRoom room;
    std::size_t triangles = 0, places = 0, normals = 0, draws = 0, bytes = 0;

  private:
    static std::size_t aligned(std::size_t n) { return (n + 255) / 256 * 256; }
};

class SharedMesh {
  public:
    // Registers GL buffer `buffer` of layout.bytes. Its context must be current whenever this
    // object is used or deleted. Throws std::runtime_error on a CUDA error.
    SharedMesh(unsigned buffer, const MeshLayout& layout, int device);
    ~SharedMesh();
    SharedMesh(const SharedMesh&) = delete;

    // Enqueues the copy of the mesh, ordered before later GL commands, without blocking the host.
    // Throws std::invalid_argument if mesh.room() differs from the layout's.
    void copy(const DeviceMesh& mesh);
    const MeshLayout& layout() const { return layout_; }

  private:
    struct State;
    std::unique_ptr<State> state;
    MeshLayout layout_;
};

}  // namespace knead
