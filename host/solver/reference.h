// The method as plain loops in double, stage after stage: what to read first, and what every other
// implementation is tested against. docs/method/model.md derives the equations whose numbers stand
// here.
#pragma once
#include <cstdint>
#include <vector>

#include "cuda/contact/cut.h"
#include "cuda/math/node4.h"
#include "cuda/mpm/lag.h"
#include "cuda/mpm/sliding.h"
#include "host/solver/solver.h"

namespace knead {

// A scene and its state. Nothing here is done for speed: particles stay in the scene's order, every
// node of the lattice is stored, every point looks at every primitive. Two things that the fast
// back ends do are left out because they are only that: masks of the primitives near a block (17),
// and clay at rest (29), (30), which is simulated like any other whatever Setup::rest says.
// The same bits for any number of threads.
class Reference : public Solver {
  public:
    // Throws std::invalid_argument for more than max_primitives.
    explicit Reference(const Setup& setup);

    FrameStats advance(const Motion& motion, double duration) override;
    // In the scene's order.
    std::vector<Particle<double>> particles() const override { return q; }
    std::vector<Gaussian<double>> gaussians() const override { return splats; }
    std::vector<double> penetration() const override;
    std::vector<Vec3<double>> velocities() const override;
    const std::vector<StageTime>& stage_times() const override { return times; }  // none
    std::size_t memory() const override;
    std::string name() const override;

    // A substep of dt [s], stage by stage; substep() calls all but the last in this order.
    void substep(const Motion& motion, double from, double to, double dt);
    // Stands the tools where they are at the share `to` of a frame, moving as from share `from` on.
    void pose(const Motion& motion, double from, double to, double dt);
    void p2g(double dt);         // particles' mass and momentum to the nodes
    void grid(double dt);        // momenta become velocities that gravity, tools and walls allow
    void share_pressure();       // of clay that hardly changes its volume, by cells
    void g2p(double dt);         // velocities and their gradients back; position and strain move on
    void project(double dt);     // out of tools and walls; labels beside a blade
    void plasticity(double dt);  // strains back to the yield surface
    void repair();               // particles that are no longer numbers, to where they were
    // Gaussians go with the clay, within walls; and out of tools.
    void deform(const Lag& lag, bool clear);

    // By Lattice::index: momentum and mass after p2g(), velocity and mass after grid(). Field 0 is
    // of all clay; in scenes with blades those of a label leave the other label's clay out (25).
    const std::vector<Node<double>>& nodes(int field = uncut) const
    {
        return fields[std::size_t(field)];
    }
    // Where pose() put the tools, and all their primitives that act.
    Colliders<double> colliders() const;
    const Mask& acting() const { return active; }
    const FrameStats& counted() const { return stats; }  // so far in this frame

  private:
    Extremes extremes() const;
    long active_blocks() const;
    void end_cuts();

    Setup setup;  // but for its particles and Gaussians
    std::vector<Binding<double>> bindings;
    std::vector<Particle<double>> q;                // in the scene's order
    std::vector<Particle<double>> before;           // as the substep found them
    std::vector<Gaussian<double>> splats;           // in the scene's order
    std::vector<double> per_cell;                   // around each, in particles like it
    std::vector<double> depth;                      // of each in a tool, before projection [m]
    std::vector<std::vector<Node<double>>> fields;  // one, or with blades one a label: node_count
    std::vector<int> occupied;                      // nodes that hold mass
    std::vector<std::vector<Sliding<double>>> sliding;  // likewise; see sliding.h
    int substeps = 1;                                   // in all, and one
    std::vector<int> owner;                             // per sphere: its tool
    std::vector<Sphere<double>> spheres;
    std::vector<Shape<double>> shapes;
    Walls<double> walls;
    Mask active{};             // primitives of active tools
    bool blades;               // some tool is one, or was
    bool was_covered = false;  // a blade was in the clay at the end of the last frame
    long covered = 0;          // particle-substeps of this frame that a blade covers
    FrameStats stats;
    int threads;
    std::vector<StageTime> times;
};

}  // namespace knead
