// Edits of a scene, shared by both back ends: validation, and the configuration as edited so far.
#pragma once
#include <span>
#include <vector>

#include "host/solver/editable_simulator.h"

namespace knead {

// The material of a removed object has density 0.
inline bool there(const Material<double>& material) { return material.density > 0; }

// Unit of work when adding clay in parallel: up to a thousand particles of one object.
struct AddedPiece {
    std::size_t clay;                      // index into Clays
    std::span<const Particle<double>> of;  // up to 1024 particles of it
    std::size_t first;                     // index of of[0] among the particles of all clays
};
std::vector<AddedPiece> pieces_of(Clays clays);

// A scene's configuration, and the particle count of each object.
class SceneState {
  public:
    // Throws std::invalid_argument for a particle without material and for invalid materials or
    // Gaussians. Contents with labels make the scene one with cuts (SimulationConfig::cuts).
    SceneState(const SimulationConfig& config, const InitialState& contents);
    // Likewise if clay slid in a velocity field that only cuts have.
    explicit SceneState(const SavedState& state);
    explicit SceneState(const Setup& setup) : SceneState(setup, setup) {}

    const SimulationConfig& config() const { return now; }
    long count(int object) const { return counts[std::size_t(object)]; }
    long count() const;
    double mass() const;  // of all clay [kg]

    // The scene with other contents, and with the materials, gravity, walls, contact of
    // bodies and cuts of `config`:
    // EditableSimulator::replace(). Labels in the contents make cuts. Throws std::invalid_argument
    // for invalid contents.
    SceneState replaced(const SimulationConfig& config, const ClayRows& clay) const;
    SceneState replaced(const SimulationConfig& config, const InitialState& contents) const;
    // Whether a scene that differs by such a replacement only has the same configuration and the
    // same number of particles in each object.
    bool same_rules(const SceneState& replacement) const;

    // Throws std::invalid_argument for invalid edits. Strong guarantee.
    std::vector<int> add_each(const Material<double>& material, Clays clays);
    void remove_each(std::span<const int> objects);
    // Whether set_material() would change the object's category and nothing else.
    bool changes_category_only(int object, const Material<double>& material) const;
    // Returns the object's previous plasticity law.
    Plasticity set_material(int object, const Material<double>& material);
    void set_gravity(Vec3<double> gravity);
    void set_walls(const WallOptions& walls);
    void set_contact(const BodyContact& contact);
    void set_tools(const Rig& rig, const std::vector<Tool<double>>& tools);
    void check_attach(int object, const std::vector<Vec3<double>>& places) const;
    template <class R>
    void check_gaussians(const std::vector<Gaussian<R>>& all) const;
    void check_placed(std::span<const GaussianPlace> places) const;

    void check_object(int object) const;
    // Throws std::invalid_argument unless the motion is finite and rigid.
    static void check_motion(const RigidMotion<double>& motion);
    // Throws std::invalid_argument unless x lies between the walls.
    void check_place(Vec3<double> x, const char* what = "clay") const;

  private:
    bool known(int object) const;  // exists and is not removed
    SceneState emptied(const SimulationConfig& config) const;
    template <class Change>
    void check_with(Change&& change) const;
    template <class At>
    void fill(std::size_t count, At&& particle);

    SimulationConfig now;
    std::vector<long> counts;
};

// Throws std::invalid_argument if elasticity and plasticity of a material are incompatible or one
// of its constants is not finite.
void check_materials(const std::vector<Material<double>>& materials);

// Throws std::invalid_argument if rig and tools are inconsistent, or if there are more primitives
// than a contact mask has bits.
void check_rig(const Rig& rig, const std::vector<Tool<double>>& tools);

// Throws std::invalid_argument if an edit refers to a missing Gaussian or particle.
void check_edits(const GaussianEdits& edits, std::size_t gaussians, std::size_t particles);

// Throws std::invalid_argument if the state is incomplete, or if its lattice has another size or
// spacing than that of the configuration.
void check_state(const SavedState& state, const SimulationConfig& of);

// Consecutive frames at rest per stored block of a lattice; 0 for blocks that the state does not
// store.
template <class R>
std::vector<int> quiet_over(const SavedState& state, const Lattice<R>& lattice)
{
    const Lattice<R> box{lattice.size, lattice.dx, lattice.spacing, state.quiet_low,
                         state.quiet_stored};
    std::vector<int> quiet(std::size_t(lattice.block_count()));
    for (std::size_t b = 0; b < quiet.size(); ++b) {
        const Int3 node = block_edge * lattice.block_at(int(b));
        if (box.stores(node) && std::size_t(box.block_of(node)) < state.quiet.size())
            quiet[b] = state.quiet[std::size_t(box.block_of(node))];
    }
    return quiet;
}

}  // namespace knead
