// Builds without CUDA or the OpenGL header that CUDA needs: no sharing.
#ifndef KNEAD_HAS_SHARE
#include <stdexcept>

#include "host/share/shared_mesh.h"
#include "host/share/shared_splats.h"
#include "host/share/sharing.h"

namespace knead {
namespace {

#ifdef KNEAD_HAS_CUDA
constexpr const char* why = "this build cannot share memory with OpenGL";
#else
constexpr const char* why = "this build has no CUDA side";
#endif
[[noreturn]] void refuse() { throw std::runtime_error(why); }

}  // namespace

Sharing sharing(int)
{
    return {false,
            std::string("pictures are copied from CUDA to OpenGL through host memory: ") + why};
}

struct SharedMesh::State {};
SharedMesh::SharedMesh(unsigned, const MeshLayout&, int) { refuse(); }
SharedMesh::~SharedMesh() = default;
void SharedMesh::copy(const DeviceMesh&) { refuse(); }

struct SharedSplats::State {};
SharedSplats::SharedSplats(int) { refuse(); }
SharedSplats::~SharedSplats() = default;
void SharedSplats::take(int, unsigned, unsigned, int, int) { refuse(); }
void SharedSplats::drop() { refuse(); }
void SharedSplats::draw(GpuRaster&, const SplatFrame&, const DeviceGaussians*) { refuse(); }
double SharedSplats::seconds() const { return 0; }

}  // namespace knead
#endif
