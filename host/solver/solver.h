// Interface of the simulator, common to all back ends: constructed from a Setup, then advanced
// frame by frame.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "cuda/contact/contact.h"
#include "cuda/contact/skinning.h"
#include "cuda/mpm/edit.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/sleep.h"
#include "cuda/mpm/time_step.h"
#include "cuda/mpm/walls.h"
#include "cuda/splats/deform.h"
#include "host/solver/counters.h"
#include "host/solver/rig.h"

namespace knead {

// Limits of the substep length dt.  (22)
struct StepOptions {
    double fixed = 0;       // [s]; 0: chosen by stability
    double courant = 0.97;  // dt <= courant * stability limit of a single particle
    double tool = 0.5;      // dt <= tool * min(r, dx) / |v of a tool|
    double largest = 1e-2;  // [s]
};

struct Setup {
    Lattice<double> lattice{};
    WallOptions walls{};
    Vec3<double> gravity{};                   // [m/s^2]
    std::vector<Material<double>> materials;  // one per object
    std::vector<Particle<double>> particles;
    std::vector<Gaussian<double>> gaussians{};  // attached to the objects' clay
    Rig rig;                                    // of all tools; Primitive::tool indexes `tools`
    std::vector<Tool<double>> tools;
    StepOptions step;
    bool grid_contact = true;  // apply tool contact to grid velocities
    int passes = 1;            // projection passes per substep; 0: no particle projection
    Rest<double> rest{};       // sleeping: which clay is not moved
    bool deterministic = false;
    int threads = 0;    // CPU; 0: all
    bool cuts = false;  // particles carry labels of a cut (cut.h), even if no tool is a blade now
};

// Joints of the rig at the start and the end of a frame, in the simulation's coordinates and scale.
struct Motion {
    std::vector<Joint<double>> from, to;  // at least as many each as the rig's spheres index
    std::vector<char> active{};           // per tool; missing entries: active
    // Per tool, factor of its radii; missing entries: 1. A tool that appears inside clay at full
    // size would throw it: grow it over some tenths of a second.
    std::vector<float> size{};
    // Per tool, scale relative to the rig in this frame; missing entries: 1. Precondition:
    // positive.
    std::vector<Stretch<float>> stretch{};

    Stretch<float> stretch_of(std::size_t tool) const
    {
        return tool < stretch.size() ? stretch[tool] : Stretch<float>{};
    }
};

extern const char* const limit_names[int(Limit::count)];

// Statistics of one frame.
struct FrameStats {
    int substeps = 0;
    double dt_min = 0, dt_max = 0;                 // [s]
    long limits[int(Limit::count)] = {};           // substeps limited by each criterion
    long yielded = 0, projected = 0;               // particle-substeps
    long clipped = 0, confined = 0, repaired = 0;  // guards: clamped nodes, confined and repaired
                                                   // particles
    long abrupt = 0, moved_far = 0;  // guards, particle-substeps: dt |C| > 0.35; projected by more
                                     // than a cell
    long clipped_negligible = 0;     // clamped nodes of negligible mass
    double found_depth = 0;          // largest penetration before projection [m]
    std::uint32_t touched = 0;       // bits, tool_bit(): tools with particles inside or at a blade
    long active_blocks = 0;          // in the last substep
    long moved = 0;     // particle-substeps computed; < particles * substeps if clay slept
    long woken = 0;     // sleeping blocks woken by a push
    long stranded = 0;  // Gaussian-substeps without clay in reach: not moved
    long splats_projected = 0, splats_repaired = 0;  // Gaussian-substeps, as for particles above
    bool cut = false;                                // ended early by the StopCheck
    double reached = 0;                              // if cut: simulated part of the frame [s]
};

// Progress of a frame between two substeps.
struct FrameProgress {
    int substeps = 0;
    double reached = 0, duration = 0;  // [s]: simulated so far; of the whole frame
};
// Called on the thread that advances or collects; return true to end the frame early. CPU: called
// after every substep but the last of a frame. GPU: called every 20 ms of a frame that takes more
// than 30 ms; the frame ends a few substeps later, and a frame submitted behind it is cut at its
// start.
using StopCheck = std::function<bool(const FrameProgress&)>;

// Wall time of one stage over one frame [s]; the names are those of the profiler ranges.
struct StageTime {
    std::string name;
    double seconds;
};

// The complete state of a solver, kept in the solver's own memory: cheap enough to take before
// every edit. Stays valid when the solver changes or is destroyed.
class Snapshot {
  public:
    virtual ~Snapshot() = default;
    virtual std::size_t bytes() const = 0;
};

// A node whose clay slid along a wall at the end of the last substep (sliding.h).
struct SlidingNode {
    int place;  // index into the sliding places of the lattice, one velocity field after the other
    float force, time, impulse_deficit;  // [N] [s] [N s]
};

// The complete state as plain values on the host: for files, undo, and other solvers of the same
// kind.
struct SavedState {
    Setup setup;              // with particles, by id, and Gaussians
    std::vector<int> order;   // ids in the solver's particle order, on which the CPU's sums depend
    float speed_squared = 0;  // of the fastest particle, as computed by the solver [m^2/s^2]
    float stiffness = 0;      // largest of all particles, likewise [m^2/s^2]
    double drift = 1e30;      // upper bound of the displacement since the last sort [m]
    // Sleeping: consecutive frames at rest per block of a box of the lattice.
    Int3 quiet_low{}, quiet_stored{};  // nodes
    std::vector<int> quiet;
    bool covered = false;  // a blade was in the clay at the end of the last frame
    std::vector<SlidingNode> sliding;
};

namespace gpu {
struct Clay;            // cuda/surface/surface.cuh: device pointers of a solver's particles
struct MovedGaussians;  // cuda/splats/deform.cuh: and of its Gaussians
}  // namespace gpu

// Precondition: no Gaussian is split twice.
struct GaussianEdits {
    std::vector<GaussianSplit> splits;
    std::vector<GaussianBeside> added;
    std::vector<GaussianPlace> placed{};
    bool any() const { return !splits.empty() || !added.empty() || !placed.empty(); }
};

// A subset of a solver's Gaussians and their indices in the order of attachment, ascending.
struct SomeGaussians {
    std::vector<int> indices;
    std::vector<Gaussian<double>> gaussians;
};

struct SnapshotData {
    std::vector<Particle<double>> particles;
    std::vector<Gaussian<double>> gaussians;
};

// The particles of several objects, one vector each.
using Clays = std::span<const std::vector<Particle<double>>>;

class Solver {
  public:
    virtual ~Solver() = default;
    // Simulates `duration` [s] with the tools moving along `motion`.
    virtual FrameStats advance(const Motion& motion, double duration) = 0;
    // Asynchronous variant of advance(): a frame can be submitted while the previous one is being
    // computed. At most two frames are in flight; meanwhile call only submit() and collect().
    virtual void submit(const Motion& motion, double duration)
    {
        done.push_back(advance(motion, duration));
    }
    virtual FrameStats collect()
    {
        const FrameStats first = done.at(0);
        done.erase(done.begin());
        return first;
    }

    // Replaces the watch of all later frames; an empty function removes it.
    void set_stop_check(StopCheck by) { stop_check = std::move(by); }

    // Edits. Precondition: no frame in flight. Afterwards the solver behaves like one constructed
    // from the edited scene. Throws std::invalid_argument for invalid edits and std::runtime_error
    // when out of device memory. Strong guarantee.

    // Adds an object of one material, at rest or moving; sets Particle::object. Returns the
    // object's number, which is never reused, even after remove().
    int add(const Material<double>& material, const std::vector<Particle<double>>& clay)
    {
        return add_each(material, {&clay, 1}).at(0);
    }
    // Adds one object per element of `clays`.
    virtual std::vector<int> add_each(const Material<double>& material, Clays clays);
    void remove(int object) { remove_each({&object, 1}); }
    virtual void remove_each(std::span<const int> objects);
    // The particles keep their volume; their mass is volume times the new density.
    virtual void set_material(int object, const Material<double>& material);
    virtual void move(int object, const RigidMotion<double>& motion);
    virtual void set_gravity(Vec3<double> gravity);  // [m/s^2]
    // The next substep projects clay behind a wall onto it.
    virtual void set_walls(const WallOptions& walls);
    // Replaces all tools. Later motions are of this rig.
    virtual void set_tools(const Rig& rig, const std::vector<Tool<double>>& tools);
    // Adds undeformed Gaussians at these places [m]. They follow the object's clay and are moved
    // and removed with it.
    virtual void attach(int object, const std::vector<Vec3<double>>& places);
    // Replaces all Gaussians, with their deformation and in this order. The clay is unaffected: its
    // next frame has the same bits.
    virtual void set_gaussians(const std::vector<Gaussian<double>>& all);
    // Edits some of many Gaussians at little cost. New ones are appended: the second half of each
    // split, in order, then `added`, then `placed`. The caller restores spatial order where it
    // needs it.
    virtual void edit_gaussians(const GaussianEdits& edits);
    // The setup as edited, without particles and Gaussians. The material of a removed object is all
    // zero.
    virtual const Setup& rules() const;

    virtual std::shared_ptr<const Snapshot> snapshot() const;
    // Precondition: the snapshot is of this solver. Throws std::invalid_argument otherwise.
    virtual void restore(const Snapshot& snapshot);
    // Contents of a snapshot; particles by id. Thread-safe, also while the solver computes.
    virtual SnapshotData held(const Snapshot& snapshot) const;
    // The Gaussians of these objects in a snapshot, likewise thread-safe.
    virtual SomeGaussians gaussians_of(const Snapshot& snapshot,
                                       std::span<const int> objects) const;
    virtual SavedState save() const;
    virtual void load(const SavedState& state);
    // Version of the state; incremented by each frame, edit and restore. Equal versions: nothing to
    // redraw.
    virtual long version() const { return 0; }

    virtual std::size_t particle_count() const { return particles().size(); }
    // The particles in unspecified order (deterministic for equal runs).
    virtual std::vector<Particle<double>> particles() const = 0;
    // In the order of attachment.
    virtual std::vector<Gaussian<double>> gaussians() const { return {}; }
    // Positions of the particles in a box [m], in unspecified order.
    virtual std::vector<Vec3<double>> places(Vec3<double> low, Vec3<double> high) const;
    // Depth [m] of every particle inside a tool at the end of the last frame; others are omitted.
    virtual std::vector<double> penetration() const = 0;
    // Velocity [m/s] that (8) interpolated from the lattice for each particle in the last substep,
    // in the order of particles(). Differs from Particle::v for particles found in a tool (19):
    // their v is the exit velocity, which the clay around damps before it moves anything. Empty if
    // no tool was active; equal to Particle::v after an edit or stage_times().
    virtual std::vector<Vec3<double>> velocities() const { return {}; }
    virtual const std::vector<StageTime>& stage_times() const = 0;
    // Hardware counters of the GPU per stage of the last frame. Empty if unsupported; throws
    // std::runtime_error if they cannot be read.
    virtual std::vector<StageWork> stage_counts() const { return {}; }
    // Device pointers of the particles, for building the surface; null on the CPU.
    virtual const gpu::Clay* clay() const { return nullptr; }
    // Device pointers of the Gaussians, for drawing; null on the CPU.
    virtual const gpu::MovedGaussians* moved_gaussians() const { return nullptr; }
    virtual std::size_t memory() const = 0;  // [bytes]
    virtual std::string name() const = 0;    // "cpu float, ...", "cuda: NVIDIA H200"

  protected:
    bool has_stop_check() const { return bool(stop_check); }
    // Call after each substep. Returns whether the frame ends here and records it in `stats`.
    bool ends_here(double reached, double duration, FrameStats& stats) const
    {
        stats.cut = stop_check && stop_check({stats.substeps, reached, duration});
        if (stats.cut) stats.reached = reached;
        return stats.cut;
    }

  private:
    StopCheck stop_check;
    std::vector<FrameStats> done;
};

// Single precision. For double precision: Reference (host/solver/reference.h).
std::unique_ptr<Solver> cpu_solver(const Setup& setup);
// Throws std::runtime_error if there is no device. Without CUDA it is declared and always throws.
std::unique_ptr<Solver> gpu_solver(const Setup& setup, int device);
bool gpu_present();
// Number of times the host has waited for a device so far.
long gpu_waits();

}  // namespace knead
