// What both back ends agree on about edits: what can be, and what becomes of the rules.
#pragma once
#include <span>
#include <vector>

#include "host/solver/solver.h"

namespace knead {

// A removed object has a material of density 0.
inline bool there(const Material<double>& material) { return material.density > 0; }

// In a box, whose faces belong to it.
template <class R>
bool within(Vec3<R> x, Vec3<R> low, Vec3<R> high)
{
    return x.x >= low.x && x.x <= high.x && x.y >= low.y && x.y <= high.y && x.z >= low.z &&
           x.z <= high.z;
}

// What threads share of clay that is added: a thousand particles of one object.
struct AddedPiece {
    std::size_t clay;                      // which of them
    std::span<const Particle<double>> of;  // `first` of all and on
    std::size_t first;
};
std::vector<AddedPiece> pieces_of(Clays clays);

// A scene's setup without its particles and Gaussians, and how many of them each object has.
class SceneState {
  public:
    // Throws std::invalid_argument where a particle has no material, or a material or a Gaussian
    // cannot be.
    explicit SceneState(const Setup& setup);

    const Setup& setup() const { return now; }
    long count(int object) const { return counts[std::size_t(object)]; }
    long count() const;
    double mass() const;  // of all clay [kg]

    // Each throws std::invalid_argument, and changes nothing, where the edit cannot be.
    std::vector<int> add_each(const Material<double>& material, Clays clays);
    void remove_each(std::span<const int> objects);
    // Returns the law that the object had.
    Plasticity set_material(int object, const Material<double>& material);
    void set_gravity(Vec3<double> gravity);
    void set_walls(const WallOptions& walls);
    void set_tools(const Rig& rig, const std::vector<Tool<double>>& tools);
    void check_attach(int object, const std::vector<Vec3<double>>& places) const;
    void check_gaussians(const std::vector<Gaussian<double>>& all) const;
    void check_placed(std::span<const GaussianPlace> places) const;

    void check_object(int object) const;
    // A motion must be finite and rigid.
    static void check_motion(const RigidMotion<double>& motion);
    // What is at x must be between the walls.
    void check_place(Vec3<double> x, const char* what = "clay") const;

  private:
    bool known(int object) const;  // and still there

    Setup now;
    std::vector<long> counts;
};

// Throws std::invalid_argument where a material's elasticity and plasticity do not go together, or
// one of its constants is not finite.
void check_materials(const std::vector<Material<double>>& materials);

// Throws std::invalid_argument where a rig and its tools do not hang together, or no mask has room
// for them.
void check_rig(const Rig& rig, const std::vector<Tool<double>>& tools);

// Throws std::invalid_argument for edits of Gaussians, beside particles, that there are not.
void check_edits(const GaussianEdits& edits, std::size_t gaussians, std::size_t particles);

// Throws std::invalid_argument where the state is not whole, or not of such a lattice.
void check_state(const SavedState& state, const Setup& of);

// Frames on end at rest by block of what a lattice stores; 0 for blocks that the state lacks.
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
