// The surface on the GPU: the same steps as in surface.h, from particles to a mesh in device
// memory.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "host/solver/simulator.h"
#include "host/surface/device_mesh.h"
#include "host/surface/surface.h"

namespace knead {
namespace gpu {
struct Clay;         // cuda/surface/surface.cuh: a solver's particles
struct SurfaceView;  // cuda/surface/surface.cuh: the mesh
}  // namespace gpu

// How much of the last surface was recomputed, in blocks of 4^3 nodes per category.
struct SurfaceWork {
    long blocks = 0;                   // non-empty blocks
    long deposited = 0, smoothed = 0;  // of these: recomputed sums; recomputed densities and later
                                       // stages
};

// Surfaces of one scene, updated incrementally: parts whose clay has not moved since the last
// surface, as reported by the solver, are kept. Bitwise equal to the result of a new GpuSurface.
// `particles` determines the objects and the amount of clay; the positions may change later.
// `device` -1: the calling thread's device. Throws std::invalid_argument for invalid options,
// std::runtime_error for a lattice that is too large, or if there is no device.
class GpuSurface {
  public:
    GpuSurface(const std::vector<Particle<double>>& particles,
               const std::vector<Material<double>>& materials, const SurfaceOptions& options,
               SurfaceRoom room = {}, int device = -1);
    ~GpuSurface();

    // Updates the materials after an edit. Categories without clay have no mesh from now on.
    // Returns false, with no effect, if a new GpuSurface is required: for a new category, for
    // particles larger than the largest before, or if a category has lost its largest and those
    // left need another scale.
    bool set_materials(const std::vector<Material<double>>& materials);

    // Enqueues all stages on the stream that moves the clay; does not block. A surface that exceeds
    // the capacity is empty, and settled() throws. Precondition: as many particles as in the
    // constructor.
    void launch(const gpu::Clay& clay);
    const gpu::SurfaceView& view() const;

    // Statistics of the last surface. Precondition: its stream has completed. Throws
    // std::runtime_error if the surface exceeded the capacity.
    SurfaceStats settled() const;
    SurfaceWork work() const;
    void forget();         // recompute the next surface completely
    void reset_advance();  // no Mesh::advance for the next surface
    SurfaceRoom needed() const;
    std::vector<Mesh> meshes() const;
    // Densities of a category on the whole lattice, with the empty layer around it.
    Field density(int category) const;

    // Launches and waits. Grows the capacity unless the constructor fixed it.
    std::vector<Mesh> surface(const gpu::Clay& clay, SurfaceStats* stats = nullptr);
    // The same, with the mesh kept on the device. Memory of released meshes is reused.
    std::shared_ptr<const DeviceMesh> kept(const gpu::Clay& clay, SurfaceStats* stats = nullptr);
    // Asynchronous variant. launch_kept() enqueues the surface and the copy, as launch() does;
    // launched() waits for them only. Null if nothing was launched since, or if the capacity was
    // exceeded and has grown: call kept().
    void launch_kept(const gpu::Clay& clay);
    std::shared_ptr<const DeviceMesh> launched(SurfaceStats* stats = nullptr);
    // From particles on the host, of any number.
    std::vector<Mesh> surface(const std::vector<Particle<double>>& particles,
                              SurfaceStats* stats = nullptr);
    std::shared_ptr<const DeviceMesh> kept(const std::vector<Particle<double>>& particles,
                                           SurfaceStats* stats = nullptr);

    // Benchmarks: durations of `count` replays of the last surface's graph, for unmoved clay if the
    // solver reports motion; and of each stage of a complete surface, by replaying a graph of that
    // stage alone [s].
    std::vector<double> replays(int count);
    std::vector<StageTime> stage_times();
    // Hardware counters of each stage of a complete surface; see StageProfile::counts().
    std::vector<StageWork> stage_counts();

    SurfaceRoom room() const;
    std::size_t memory() const;  // device memory [bytes]

  private:
    struct State;
    std::unique_ptr<State> state;
};

}  // namespace knead
