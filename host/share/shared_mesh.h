// A buffer of OpenGL's that takes meshes from a CUDA device on that device.
#pragma once
#include <memory>

#include "host/surface/device_mesh.h"

namespace knead {

// Where the parts of a mesh lie in one buffer, by byte: three indices of 32 bits a triangle, four
// floats a vertex for its place and as many for its normal, and five words a category as
// glDrawElementsIndirect reads them.
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
    // Registers a buffer of layout.bytes, GL's name, of the context that is current whenever this
    // is used or deleted. Throws std::runtime_error where CUDA refuses.
    SharedMesh(unsigned buffer, const MeshLayout& layout, int device);
    ~SharedMesh();
    SharedMesh(const SharedMesh&) = delete;

    // Copies it there, for what GL draws from now on, and waits for nothing. Its room must be that
    // of the layout.
    void copy(const DeviceMesh& mesh);
    const MeshLayout& layout() const { return layout_; }

  private:
    struct State;
    std::unique_ptr<State> state;
    MeshLayout layout_;
};

}  // namespace knead
