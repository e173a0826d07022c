// Stubs of the GPU surface for builds without CUDA.
#ifndef KNEAD_HAS_CUDA
#include <stdexcept>

#include "host/surface/gpu_surface.h"

namespace knead {
namespace {

[[noreturn]] void refuse()
{
    throw std::runtime_error("no CUDA device: this build has no CUDA side");
}

}  // namespace

struct GpuSurface::State {};
GpuSurface::GpuSurface(const std::vector<Particle<double>>&, const std::vector<Material<double>>&,
                       const SurfaceOptions&, SurfaceRoom, int)
{
    refuse();
}
GpuSurface::~GpuSurface() = default;
bool GpuSurface::set_materials(const std::vector<Material<double>>&) { refuse(); }
void GpuSurface::launch(const gpu::Clay&) { refuse(); }
const gpu::SurfaceView& GpuSurface::view() const { refuse(); }
SurfaceStats GpuSurface::settled() const { refuse(); }
SurfaceWork GpuSurface::work() const { refuse(); }
void GpuSurface::forget() { refuse(); }
void GpuSurface::reset_advance() { refuse(); }
SurfaceRoom GpuSurface::needed() const { refuse(); }
std::vector<Mesh> GpuSurface::meshes() const { refuse(); }
Field GpuSurface::density(int) const { refuse(); }
std::vector<Mesh> GpuSurface::surface(const gpu::Clay&, SurfaceStats*) { refuse(); }
std::vector<Mesh> GpuSurface::surface(const std::vector<Particle<double>>&, SurfaceStats*)
{
    refuse();
}
std::shared_ptr<const DeviceMesh> GpuSurface::kept(const gpu::Clay&, SurfaceStats*) { refuse(); }
std::shared_ptr<const DeviceMesh> GpuSurface::kept(const std::vector<Particle<double>>&,
                                                   SurfaceStats*)
{
    refuse();
}
void GpuSurface::launch_kept(const gpu::Clay&) { refuse(); }
std::shared_ptr<const DeviceMesh> GpuSurface::launched(SurfaceStats*) { refuse(); }
std::vector<double> GpuSurface::replays(int) { refuse(); }
std::vector<StageTime> GpuSurface::stage_times() { refuse(); }
std::vector<StageWork> GpuSurface::stage_counts() { refuse(); }
SurfaceRoom GpuSurface::room() const { refuse(); }
std::size_t GpuSurface::memory() const { refuse(); }

DeviceMesh::DeviceMesh(std::shared_ptr<gpu::KeptMesh>, std::vector<int>, const gpu::MeshInfo&)
{
    refuse();
}
int DeviceMesh::device() const { refuse(); }
SurfaceRoom DeviceMesh::room() const { refuse(); }
std::vector<Mesh> DeviceMesh::meshes() const { refuse(); }

}  // namespace knead
#endif
