// The simulator behind one face, whatever it runs on: set up once, then advanced frame by frame.
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

// How long a substep may be.  (22)
struct StepOptions {
    double fixed = 0;       // [s]; 0: as stability asks
    double courant = 0.97;  // dt <= courant times what a lone particle is stable with
    double tool = 0.5;      // dt <= tool * min(r, dx) / |v of a tool|
    double largest = 1e-2;  // [s]
};

struct Setup {
    Lattice<double> lattice{};
    WallOptions walls{};
    Vec3<double> gravity{};                   // [m/s^2]
    std::vector<Material<double>> materials;  // one per object
    std::vector<Particle<double>> particles;
    std::vector<Gaussian<double>> gaussians{};  // that follow the objects' clay
    Rig rig;                                    // all tools; Primitive::tool indexes `tools`
    std::vector<Tool<double>> tools;
    StepOptions step;
    bool grid_contact = true;  // the grid feels the tools
    int passes = 1;            // of particle projection a substep; 0: none
    Rest<double> rest{};       // which clay need not move
    bool deterministic = false;
    int threads = 0;    // CPU: 0 = all
    bool cuts = false;  // its clay carries the labels of a cut (cut.h), whether or not a tool is a
                        // blade now
};

// The joints that the rig hangs on at the two ends of a frame, in the simulation's frame and size.
struct Motion {
    std::vector<Joint<double>> from, to;  // as many each as the rig's spheres name, or more
    std::vector<char> active{};           // per tool; tools beyond its end are active
    // Per tool, the share of its radii that it has, 1 beyond its end. One that appears inside of
    // clay would throw it: let it grow, over some tenths of a second.
    std::vector<float> size{};
    // Per tool, how large it is against the rig in this frame; 1 beyond its end. Positive.
    std::vector<Stretch<float>> stretch{};

    Stretch<float> stretch_of(std::size_t tool) const
    {
        return tool < stretch.size() ? stretch[tool] : Stretch<float>{};
    }
};

extern const char* const limit_names[int(Limit::count)];

// What one frame did.
struct FrameStats {
    int substeps = 0;
    double dt_min = 0, dt_max = 0;                 // [s]
    long limits[int(Limit::count)] = {};           // substeps cut by each limit
    long yielded = 0, projected = 0;               // particle-substeps
    long clipped = 0, confined = 0, repaired = 0;  // guards: nodes slowed, particles put back
    long abrupt = 0, moved_far = 0;  // guards, particle-substeps: dt |C| > 0.35; put out of a tool
                                     // by more than a cell
    long clipped_negligible = 0;     // nodes slowed that hold next to nothing
    double found_depth = 0;          // deepest before projection [m]
    std::uint32_t touched = 0;       // tools that found clay inside, or at a blade: tool_bit()
    long active_blocks = 0;          // of the last substep
    long moved = 0;     // particle-substeps: less than their product where clay was still
    long woken = 0;     // blocks of still clay that were pushed
    long stranded = 0;  // Gaussian-substeps with no clay around: they stay where they are
    long splats_projected = 0, splats_repaired = 0;  // Gaussian-substeps, as of particles above
    bool cut = false;    // it was ended before its time, as who watches it asked
    double reached = 0;  // where it was cut: how far it came [s]
};

// Where a frame stands between two of its substeps.
struct FramePart {
    int substeps = 0;
    double reached = 0, duration = 0;  // [s] of the frame: simulated so far, in all
};
// Asked by the thread that advances or collects; true ends the frame there. On the CPU after every
// substep but a frame's last; on a GPU every 20 ms of a frame that takes more than 30, which ends a
// few substeps later, and one that was submitted behind it does nothing and is cut, too.
using FrameWatch = std::function<bool(const FramePart&)>;

// Wall time of a stage over one frame [s]; names are those of the profiler ranges.
struct StageTime {
    std::string name;
    double seconds;
};

// All that decides the future of a solver, where the solver keeps it: cheap enough for every edit.
// Outlives changes of the solver, and the solver itself.
class Snapshot {
  public:
    virtual ~Snapshot() = default;
    virtual std::size_t bytes() const = 0;
};

// A node whose clay slid along a wall when the last substep ended (sliding.h).
struct SlidingNode {
    int place;  // of the lattice's, those of one velocity field after the other
    float force, time, impulse_deficit;  // [N] [s] [N s]
};

// The same in plain values on the host: for files, for undo, for another solver of the same kind.
struct SavedState {
    Setup setup;              // with its particles, by id, and its Gaussians
    std::vector<int> order;   // ids as the solver keeps them: the CPU's sums depend on it
    float speed_squared = 0;  // of the fastest particle, as the solver found it [m^2/s^2]
    float stiffness = 0;      // of the stiffest, likewise [m^2/s^2]
    double drift = 1e30;      // how far clay may have come since it was sorted [m]
    // Where clay may be still: frames on end at rest, by block of a box of the lattice.
    Int3 quiet_low{}, quiet_stored{};  // nodes
    std::vector<int> quiet;
    bool covered = false;  // a blade was in the clay when the last frame ended
    std::vector<SlidingNode> sliding;
};

namespace gpu {
struct Clay;  // cuda/surface/surface.cuh: where a solver keeps its particles on the device
struct MovedGaussians;  // cuda/splats/deform.cuh: and its Gaussians
}  // namespace gpu

// No Gaussian is split twice.
struct GaussianEdits {
    std::vector<GaussianSplit> splits;
    std::vector<GaussianBeside> added;
    std::vector<GaussianPlace> placed{};
    bool any() const { return !splits.empty() || !added.empty() || !placed.empty(); }
};

// Some of a solver's Gaussians, and their places in the order of attaching, which rise.
struct SomeGaussians {
    std::vector<int> indices;
    std::vector<Gaussian<double>> gaussians;
};

struct SnapshotData {
    std::vector<Particle<double>> particles;
    std::vector<Gaussian<double>> gaussians;
};

// The particles of several objects.
using Clays = std::span<const std::vector<Particle<double>>>;

class Solver {
  public:
    virtual ~Solver() = default;
    // Simulates `duration` [s] with the tools moving along `motion`.
    virtual FrameStats advance(const Motion& motion, double duration) = 0;
    // The same in two halves, so that a frame may be handed over while the one before it is still
    // being computed. At most two are under way; nothing else is asked meanwhile.
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

    // From now on frames are watched by `by` alone; nothing: by nobody.
    void watch_frames(FrameWatch by) { frame_watch = std::move(by); }

    // Edits, while no frame is under way. What follows is what a solver would do that was made of
    // the edited scene. They throw std::invalid_argument for what cannot be, std::runtime_error
    // where memory ends, and then leave all as it was.

    // More clay of one material, at rest or moving; Particle::object is set. Returns the object's
    // number, which no other will have, also when this one is removed.
    int add(const Material<double>& material, const std::vector<Particle<double>>& clay)
    {
        return add_each(material, {&clay, 1}).at(0);
    }
    // As many objects, at once.
    virtual std::vector<int> add_each(const Material<double>& material, Clays clays);
    void remove(int object) { remove_each({&object, 1}); }
    virtual void remove_each(std::span<const int> objects);
    // Its particles keep their volume; their mass is that times the density.
    virtual void set_material(int object, const Material<double>& material);
    virtual void move(int object, const RigidMotion<double>& motion);
    virtual void set_gravity(Vec3<double> gravity);  // [m/s^2]
    // Clay behind a face is put onto it by the next substep.
    virtual void set_walls(const WallOptions& walls);
    // All tools at once. The motions of later frames are of this rig.
    virtual void set_tools(const Rig& rig, const std::vector<Tool<double>>& tools);
    // Gaussians at these places [m], undeformed, that follow an object's clay from now on, and are
    // moved and removed with it.
    virtual void attach(int object, const std::vector<Vec3<double>>& places);
    // All Gaussians at once, deformed as they are, in this order from now on. The clay does not
    // hear of it: its next frame has the same bits.
    virtual void set_gaussians(const std::vector<Gaussian<double>>& all);
    // The same of some among many, at little cost: behind all others come the second ones of those
    // that are split, in their order, then those beside particles, then those that
    // are placed: who has many brings neighbours together.
    virtual void edit_gaussians(const GaussianEdits& edits);
    // The setup as edited, without particles and Gaussians. A removed object's material is all
    // zero.
    virtual const Setup& rules() const;

    virtual std::shared_ptr<const Snapshot> snapshot() const;
    // Of this solver, at any time. Throws std::invalid_argument for that of another.
    virtual void restore(const Snapshot& snapshot);
    // What it holds, for any thread, while the solver goes on; particles by id.
    virtual SnapshotData held(const Snapshot& snapshot) const;
    // The Gaussians of these objects in it, likewise.
    virtual SomeGaussians gaussians_of(const Snapshot& snapshot,
                                       std::span<const int> objects) const;
    virtual SavedState save() const;
    virtual void load(const SavedState& state);
    // Another after every frame, edit and restoring: who has drawn this number need not draw again.
    virtual long version() const { return 0; }

    virtual std::size_t particle_count() const { return particles().size(); }
    // The particles in no particular order (deterministic for equal runs).
    virtual std::vector<Particle<double>> particles() const = 0;
    // In the order in which they were attached.
    virtual std::vector<Gaussian<double>> gaussians() const { return {}; }
    // Where particles lie in a box, in no particular order [m].
    virtual std::vector<Vec3<double>> places(Vec3<double> low, Vec3<double> high) const;
    // Depth [m] of every particle inside a tool at the end of the last frame; 0 entries left out.
    virtual std::vector<double> penetration() const = 0;
    // The velocity [m/s] that the lattice gave each particle in the last substep (8), in the order
    // of particles(). Those have another where (19) has found them in a tool: the speed at which
    // they leave it, which is slowed by the clay around them before it moves anything. Empty where
    // no tool acted; after an edit or stage_times(), what particles() has.
    virtual std::vector<Vec3<double>> velocities() const { return {}; }
    virtual const std::vector<StageTime>& stage_times() const = 0;
    // What a GPU's counters say of the stages of the last frame. Empty where there are none; throws
    // std::runtime_error where they cannot be read.
    virtual std::vector<StageWork> stage_counts() const { return {}; }
    // Where the particles are on the device, for its surface; null where they are not on one.
    virtual const gpu::Clay* clay() const { return nullptr; }
    // Where the Gaussians are on the device, for who draws them; null where they are not on one.
    virtual const gpu::MovedGaussians* moved_gaussians() const { return nullptr; }
    virtual std::size_t memory() const = 0;  // bytes held
    virtual std::string name() const = 0;    // "cpu float, ...", "cuda: NVIDIA H200"

  protected:
    bool watched() const { return bool(frame_watch); }
    // After a substep: whether the frame ends here, which its statistics then say.
    bool ends_here(double reached, double duration, FrameStats& stats) const
    {
        stats.cut = frame_watch && frame_watch({stats.substeps, reached, duration});
        if (stats.cut) stats.reached = reached;
        return stats.cut;
    }

  private:
    FrameWatch frame_watch;
    std::vector<FrameStats> done;
};

// In float. In double there is the Reference (host/solver/reference.h).
std::unique_ptr<Solver> cpu_solver(const Setup& setup);
// Throws std::runtime_error where there is no device. Declared always; without CUDA it only throws.
std::unique_ptr<Solver> gpu_solver(const Setup& setup, int device);
bool gpu_present();
// How often the host has waited for a device so far.
long gpu_waits();

}  // namespace knead
