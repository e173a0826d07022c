// The device's stages one at a time, from host memory to host memory: what tests compare with plain
// loops over the same formulas.
#pragma once
#include <memory>
#include <vector>

#include "cuda/math/node4.h"
#include "cuda/mpm/particle.h"
#include "host/solver/solver.h"

namespace knead {

// One substep that fills a frame of `dt` [s] in which the tools move along `motion`. Throws as
// gpu_solver does.
class GpuStages {
  public:
    GpuStages(const Setup& setup, const Motion& motion, double dt);
    ~GpuStages();

    // Sorts the particles by cell; their places in the scene, in the order that they lie in now.
    std::vector<int> sort();
    // As they are, in the scene's order.
    std::vector<Particle<double>> particles();
    // Momentum and mass of every node, by Lattice::index; with Setup::deterministic of fixed point.
    std::vector<Node<float>> p2g();
    // Velocity of every node, from momenta and masses by Lattice::index.
    std::vector<Node<float>> grid(const std::vector<Node<float>>& sums);
    // The scene's particles, moved through these velocities.
    std::vector<Particle<double>> g2p(const std::vector<Node<float>>& velocities);
    // Primitives near every block of the lattice.
    std::vector<Mask> masks();
    // Runs of particles as the next frame would take them.
    std::vector<int> lined_up();

  private:
    struct State;
    std::unique_ptr<State> state;
};

}  // namespace knead
