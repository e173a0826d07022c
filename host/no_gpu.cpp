// What stands for the device where the build has none.
#ifndef KNEAD_HAS_CUDA
#include <stdexcept>

#include "gpu_material.h"
#include "gpu_room.h"
#include "gpu_stages.h"
#include "gpu_surface.h"
#include "solver.h"

namespace knead {
namespace {

[[noreturn]] void refuse()
{
    throw std::runtime_error("no CUDA device: this build has no CUDA side");
}

}  // namespace

bool gpu_present() { return false; }
long gpu_waits() { return 0; }
std::unique_ptr<Solver> gpu_solver(const Setup&, int) { refuse(); }
std::unique_ptr<Solver> gpu_solver(const Setup&, int, Room) { refuse(); }

std::vector<Functions<float>> gpu_functions(const std::vector<float>&) { refuse(); }
std::vector<Answers<float>> gpu_answers(const std::vector<Particle<float>>&,
                                        const std::vector<Material<float>>&, float)
{
    refuse();
}

struct GpuStages::Held {};
GpuStages::GpuStages(const Setup&, const Motion&, double) { refuse(); }
GpuStages::~GpuStages() = default;
std::vector<int> GpuStages::sort() { refuse(); }
std::vector<Particle<double>> GpuStages::particles() { refuse(); }
std::vector<Node<float>> GpuStages::p2g() { refuse(); }
std::vector<Node<float>> GpuStages::grid(const std::vector<Node<float>>&) { refuse(); }
std::vector<Particle<double>> GpuStages::g2p(const std::vector<Node<float>>&) { refuse(); }
std::vector<Mask> GpuStages::masks() { refuse(); }

struct GpuSurface::Held {};
GpuSurface::GpuSurface(const std::vector<Particle<double>>&, const std::vector<Material<double>>&,
                       const SurfaceRule&, SurfaceRoom, int)
{
    refuse();
}
GpuSurface::~GpuSurface() = default;
void GpuSurface::launch(const gpu::Clay&) { refuse(); }
const gpu::SurfaceView& GpuSurface::view() const { refuse(); }
SurfaceTally GpuSurface::settled() const { refuse(); }
SurfaceWork GpuSurface::work() const { refuse(); }
void GpuSurface::forget() { refuse(); }
SurfaceRoom GpuSurface::needed() const { refuse(); }
std::vector<Mesh> GpuSurface::meshes() const { refuse(); }
Field GpuSurface::density(int) const { refuse(); }
std::vector<Mesh> GpuSurface::surface(const gpu::Clay&, SurfaceTally*) { refuse(); }
std::vector<Mesh> GpuSurface::surface(const std::vector<Particle<double>>&, SurfaceTally*)
{
    refuse();
}
std::vector<double> GpuSurface::replays(int) { refuse(); }
std::vector<StageTime> GpuSurface::stage_times() { refuse(); }
std::vector<StageWork> GpuSurface::stage_counts() { refuse(); }
SurfaceRoom GpuSurface::room() const { refuse(); }
std::size_t GpuSurface::memory() const { refuse(); }

}  // namespace knead
#endif
