// The surface on the device: the same steps as in surface.h, from particles there to a mesh there.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "host/solver/solver.h"
#include "host/surface/device_mesh.h"
#include "host/surface/surface.h"

namespace knead {
namespace gpu {
struct Clay;         // cuda/surface/surface.cuh: where a solver keeps its particles
struct SurfaceView;  // cuda/surface/surface.cuh: where the mesh is
}  // namespace gpu

// How much of the last surface was recomputed, in blocks of 4^3 nodes of one category.
struct SurfaceWork {
    long blocks = 0;                   // that are not empty
    long deposited = 0, softened = 0;  // of these: sums; densities and what follows from them
};

// Surfaces of one scene. What a solver knows not to have moved since the last one is kept of it;
// the next is the same to the bit as one of a new GpuSurface. `particles` says which objects there
// are and how much clay; later ones may be elsewhere. Without a number, on the calling thread's
// device. Throws std::invalid_argument for a rule without meaning, std::runtime_error for a lattice
// too large, or where there is no device.
class GpuSurface {
  public:
    GpuSurface(const std::vector<Particle<double>>& particles,
               const std::vector<Material<double>>& materials, const SurfaceOptions& options,
               SurfaceRoom room = {}, int device = -1);
    ~GpuSurface();

    // After an edit, the clay's materials. False, and nothing has changed, where they need another
    // surface: for a category that is new, or particles larger than there were.
    bool set_materials(const std::vector<Material<double>>& materials);

    // Launches all stages behind what is queued to move the clay, and waits for nothing. A surface
    // for which there is no room is empty, and settled() says so. The particles must be as many as
    // at first.
    void launch(const gpu::Clay& clay);
    const gpu::SurfaceView& view() const;

    // Of the last surface, once its stream is done: throws std::runtime_error where it did not fit.
    SurfaceStats settled() const;
    SurfaceWork work() const;
    void forget();  // the next keeps nothing of the last
    void leap();    // of the next nothing is told of how it came to be there
    SurfaceRoom needed() const;
    std::vector<Mesh> meshes() const;
    // Densities of a category in the whole lattice, and the empty layer around it.
    Field density(int category) const;

    // Launches, waits, and takes more room where the constructor was left to choose it.
    std::vector<Mesh> surface(const gpu::Clay& clay, SurfaceStats* stats = nullptr);
    // The same, whose mesh is kept on the device. Meshes that nobody holds any more give their
    // memory to later ones.
    std::shared_ptr<const DeviceMesh> kept(const gpu::Clay& clay, SurfaceStats* stats = nullptr);
    // The same in two halves. Launched behind what is queued to move the clay, as launch(), with
    // the copy that is kept; then waited for, and for nothing else. Null where none was launched
    // since, or where it did not fit and more room was taken: kept() makes it.
    void launch_kept(const gpu::Clay& clay);
    std::shared_ptr<const DeviceMesh> launched(SurfaceStats* stats = nullptr);
    // From particles on the host, any number.
    std::vector<Mesh> surface(const std::vector<Particle<double>>& particles,
                              SurfaceStats* stats = nullptr);
    std::shared_ptr<const DeviceMesh> kept(const std::vector<Particle<double>>& particles,
                                           SurfaceStats* stats = nullptr);

    // Seconds of each of `count` replays of a graph of the last surface, by now of clay that has
    // not moved where its solver can tell, and what each stage takes of a surface that keeps
    // nothing: by a graph of that stage alone, again and again.
    std::vector<double> replays(int count);
    std::vector<StageTime> stage_times();
    // What a GPU's counters say of each stage of such a surface; see Solver::stage_counts().
    std::vector<StageWork> stage_counts();

    SurfaceRoom room() const;
    std::size_t memory() const;  // bytes held on the device

  private:
    struct State;
    std::unique_ptr<State> state;
};

}  // namespace knead
