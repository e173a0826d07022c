// A simulator whose scene can be edited, and whose state can be captured, restored, saved and
// loaded.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "cuda/mpm/edit.h"
#include "host/solver/clay_rows.h"
#include "host/solver/simulator.h"

namespace knead {

// The complete state of a simulator, kept in its own memory: cheap enough to take before every
// edit. Stays valid when the simulator changes or is destroyed.
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

// The complete state as plain values on the host: for files, undo, and other simulators of the same
// kind.
struct SavedState {
    SimulationConfig config;
    InitialState contents;  // particles by id
    std::vector<int>
        order;  // ids in the simulator's particle order, on which the CPU's sums depend
    float speed_squared = 0;  // of the fastest particle, as computed by the simulator [m^2/s^2]
    float stiffness = 0;      // largest of all particles, likewise [m^2/s^2]
    double drift = 1e30;      // upper bound of the displacement since the last sort [m]
    // Sleeping: consecutive frames at rest per block of a box of the lattice.
    Int3 quiet_low{}, quiet_stored{};  // nodes
    std::vector<int> quiet;
    bool covered = false;  // a blade was in the clay at the end of the last frame
    std::vector<SlidingNode> sliding;
};

// Precondition: no Gaussian is split twice.
struct GaussianEdits {
    std::vector<GaussianSplit> splits;
    std::vector<GaussianBeside> added;
    std::vector<GaussianPlace> placed{};
    bool any() const { return !splits.empty() || !added.empty() || !placed.empty(); }
};

// A subset of a simulator's Gaussians and their indices in the order of attachment, ascending.
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

class EditableSimulator : public Simulator {
  public:
    EditableSimulator* editable() override { return this; }
    using Simulator::editable;

    // Edits. Precondition: no frame in flight. Afterwards the simulator behaves like one
    // constructed from the edited scene. Throws std::invalid_argument for invalid edits and
    // std::runtime_error when out of device memory. Strong guarantee.

    // Adds an object of one material, at rest or moving; sets Particle::object. Returns the
    // object's number, which is never reused, even after remove().
    int add(const Material<double>& material, const std::vector<Particle<double>>& clay)
    {
        return add_each(material, {&clay, 1}).at(0);
    }
    // Adds one object per element of `clays`.
    virtual std::vector<int> add_each(const Material<double>& material, Clays clays) = 0;
    void remove(int object) { remove_each({&object, 1}); }
    virtual void remove_each(std::span<const int> objects) = 0;
    // The particles keep their volume; their mass is volume times the new density. The object
    // belongs to material.category from now on. If nothing but the category changes, no particle is
    // accessed, sleeping clay sleeps on, and the next frame has the same bits, unless objects of
    // unlike category are separate bodies (bodies.h).
    virtual void set_material(int object, const Material<double>& material) = 0;
    virtual void move(int object, const RigidMotion<double>& motion) = 0;
    virtual void set_gravity(Vec3<double> gravity) = 0;  // [m/s^2]
    // The next substep projects clay behind a wall onto it.
    virtual void set_walls(const WallOptions& walls) = 0;
    // Contact of objects of unlike category.
    virtual void set_contact(const BodyContact& contact) = 0;
    // Replaces all tools. Later motions are of this rig.
    virtual void set_tools(const Rig& rig, const std::vector<Tool<double>>& tools) = 0;
    // Adds undeformed Gaussians at these places [m]. They follow the object's clay and are moved
    // and removed with it.
    virtual void attach(int object, const std::vector<Vec3<double>>& places) = 0;
    // Replaces all Gaussians, with their deformation and in this order. The clay is unaffected: its
    // next frame has the same bits.
    virtual void set_gaussians(const std::vector<Gaussian<double>>& all) = 0;
    // Edits some of many Gaussians at little cost. New ones are appended: the second half of each
    // split, in order, then `added`, then `placed`. The caller restores spatial order where it
    // needs it.
    virtual void edit_gaussians(const GaussianEdits& edits) = 0;
    // Replaces clay, Gaussians, materials, gravity, walls and contact of bodies. Afterwards the
    // simulator gives the same bits as one constructed from config(), with these particles in order
    // of id. The tools stay, and the other options must equal this simulator's. `config.cuts`
    // applies, except that it stays true while a tool is a blade. The clay of ClayRows is at rest:
    // v = C = 0.
    virtual void replace(const SimulationConfig& config, const ClayRows& clay) = 0;
    virtual void replace(const SimulationConfig& config, const InitialState& contents) = 0;
    // As edited. The material of a removed object is all zero.
    virtual const SimulationConfig& config() const = 0;

    // The number of connected pieces by group of objects, see piece_count.h. Precondition: no frame
    // in flight.
    virtual std::vector<int> piece_counts(std::span<const int> group, int groups) const;

    virtual std::shared_ptr<const Snapshot> snapshot() const = 0;
    // Precondition: the snapshot is of this simulator. Throws std::invalid_argument otherwise.
    virtual void restore(const Snapshot& snapshot) = 0;
    // Contents of a snapshot; particles by id. Thread-safe, also while the simulator computes.
    virtual SnapshotData held(const Snapshot& snapshot) const = 0;
    // The clay of a snapshot without its velocities; likewise thread-safe.
    virtual ClayRows rows(const Snapshot& snapshot) const = 0;
    // The Gaussians of these objects in a snapshot, likewise thread-safe.
    virtual SomeGaussians gaussians_of(const Snapshot& snapshot,
                                       std::span<const int> objects) const;
    // What save() returned when the snapshot was taken; likewise thread-safe.
    virtual SavedState saved(const Snapshot& snapshot) const = 0;
    // Allocates for so many snapshots of this size at a time, and for reading one of them: they
    // then take no allocation. Precondition: no frame in flight.
    virtual void reserve_snapshots(int) {}
    virtual SavedState save() const = 0;
    virtual void load(const SavedState& state) = 0;
};

// Single precision. For double precision: Reference (host/solver/reference.h).
std::unique_ptr<EditableSimulator> cpu_solver(const Setup& setup);
// Throws std::runtime_error if there is no device. Without CUDA it is declared and always throws.
std::unique_ptr<EditableSimulator> gpu_solver(const Setup& setup, int device);
bool gpu_present();
// Number of times the host has waited for a device so far.
long gpu_waits();

}  // namespace knead
