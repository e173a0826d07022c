// The reference: all stages as plain loops in double, in order. Specification of the method and
// oracle of all tests. docs/method/model.md derives the equations that are cited by number here.
#pragma once
#include <cstdint>
#include <vector>

#include "cuda/contact/cut.h"
#include "cuda/math/node4.h"
#include "cuda/mpm/lag.h"
#include "cuda/mpm/sliding.h"
#include "host/solver/bodies.h"
#include "host/solver/simulator.h"

namespace knead {

// A scene and its state. Not optimised: particles stay in the scene's order, every node of the
// lattice is stored, every point is tested against every primitive. Two pure optimisations of the
// fast back ends are omitted: masks of primitives near a block (17) and sleeping (29), (30);
// Setup::rest is ignored. Bitwise deterministic for any number of threads.
class Reference : public Simulator {
  public:
    // Throws std::invalid_argument for more than max_primitives.
    explicit Reference(const Setup& setup);

    FrameStats advance(const Motion& motion, double duration) override;
    // In the scene's order.
    std::vector<Particle<double>> particles() const override { return q; }
    std::vector<Gaussian<double>> gaussians() const override { return splats; }
    std::vector<double> penetration() const override;
    std::vector<Vec3<double>> velocities() const override;
    std::size_t memory() const override;
    std::string name() const override;

    // One substep of dt [s]. It calls the stages below up to repair(), in this order.
    void substep(const Motion& motion, double from, double to, double dt);
    // Poses the tools at fraction `to` of the frame, with the velocity of the motion since `from`.
    void pose(const Motion& motion, double from, double to, double dt);
    void p2g(double dt);         // (1), (2): particles' mass and momentum to nodes
    void separate(double dt);    // (25a): contact of bodies of unlike category
    void grid(double dt);        // (3): momenta to velocities; gravity, tools, walls
    void share_pressure();       // (7a): mean pressure of each cell, for nearly incompressible clay
    void g2p(double dt);         // (8), (9): velocities and gradients to particles; advect, update
                                 // strain
    void project(double dt);     // (19): out of tools and walls; labels at blades
    void plasticity(double dt);  // (10), (11): return map to the yield surface
    void repair();               // resets particles with non-finite values to their previous state
    // (31)-(34): Gaussians follow the clay, within walls; if `clear`, also out of tools.
    void deform(const Lag& lag, bool clear);

    // By Lattice::index: momentum and mass after p2g(), velocity and mass after grid(). Field 0
    // sums all clay; in scenes with blades the field of a label omits the clay of the other label
    // (25); with bodies the field of a colour has the clay of this colour (25a), or of one label of
    // it, and field 0 the mean velocity.
    const std::vector<Node<double>>& nodes(int field = uncut) const
    {
        return fields[std::size_t(field)];
    }
    // The tools as posed by pose(), and the primitives of active tools.
    Colliders<double> colliders() const;
    const Mask& acting() const { return active; }
    const FrameStats& counted() const { return stats; }  // of this frame so far

  private:
    Extremes extremes() const;
    long active_blocks() const;
    void end_cuts();
    std::uint32_t sliced_side(std::size_t field, Int3 node) const;
    void put_bodies(Int3 node, Node<double> (&fields_there)[most_fields]);
    // Index of the velocity field of clay of an object with this label.
    std::size_t field_of(int object, std::uint32_t label) const
    {
        return bodies.colours > 0 ? std::size_t(bodies.field_of(object, label))
               : blades           ? std::size_t(label)
                                  : std::size_t(uncut);
    }

    SimulationConfig scene;
    std::vector<Binding<double>> bindings;
    std::vector<Particle<double>> q;                // in the scene's order
    std::vector<Particle<double>> before;           // at the beginning of the substep
    std::vector<Gaussian<double>> splats;           // in the scene's order
    std::vector<double> per_cell;                   // mass around each particle per cell, in
                                                    // particle masses
    std::vector<double> depth;                      // penetration of each before projection [m]
    std::vector<std::vector<Node<double>>> fields;  // node_count each: 1 field, or with blades 3
                                                    // (uncut and one per label), or with bodies 1
                                                    // + colours
    std::vector<int> occupied;                      // indices of nodes with mass
    std::vector<std::vector<Sliding<double>>> sliding;  // per field; see sliding.h
    int substeps = 1;                                   // number of substeps so far, plus one
    std::vector<int> owner;                             // tool of each sphere
    std::vector<Sphere<double>> spheres;
    std::vector<Shape<double>> shapes;
    Walls<double> walls;
    Bodies bodies;
    Mask active{};             // primitives of active tools
    bool blades;               // a tool is a blade, or clay has been cut
    bool was_covered = false;  // a blade was in the clay at the end of the last frame
    FrameStats stats;
    int threads;
};

}  // namespace knead
