#include <stdexcept>

#include "cuda/device/device.cuh"
#include "host/share/registered.cuh"
#include "host/share/shared_mesh.h"
#include "host/surface/device_mesh.cuh"

namespace knead {

using namespace gpu;

struct SharedMesh::State {
    int device;
    Registered buffer;
    Stream stream;
};

SharedMesh::SharedMesh(unsigned buffer, const MeshLayout& layout, int device) : layout_(layout)
{
    static_assert(sizeof(DrawCommand) == MeshLayout::command);
    device = chosen(device);
    state.reset(new State{device, Registered::buffer(buffer), {}});
}
SharedMesh::~SharedMesh() = default;

void SharedMesh::copy(const DeviceMesh& mesh)
{
    const SurfaceRoom room = mesh.room();
    if (room.vertices != layout_.room.vertices || room.triangles != layout_.room.triangles)
        throw std::invalid_argument("the mesh does not match the buffer's layout");
    check(cudaSetDevice(state->device), "device");
    const KeptMesh& from = mesh.kept();
    cudaGraphicsResource_t resource = state->buffer;
    Mapped mapped(&resource, 1, state->stream);
    void* at = nullptr;
    std::size_t bytes = 0;
    check(cudaGraphicsResourceGetMappedPointer(&at, &bytes, resource), "sharing with OpenGL");
    if (bytes < layout_.bytes) throw std::invalid_argument("a buffer that is too small");
    const auto part = [&](std::size_t offset) {
        return static_cast<void*>(static_cast<unsigned char*>(at) + offset);
    };
    const MeshPlace to{static_cast<Int3*>(part(layout_.triangles)),
                       static_cast<float4*>(part(layout_.places)),
                       static_cast<float4*>(part(layout_.normals)),
                       static_cast<DrawCommand*>(part(layout_.draws)), nullptr};
    copy_mesh(from.place(), to, int(mesh.categories().size()), from.processors, state->stream);
    check(cudaEventRecord(from.read, state->stream), "surface");
    mapped.end();
}

}  // namespace knead
