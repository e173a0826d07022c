// The device's stages one at a time, host memory in and out, for comparison with plain loops over
// the same formulas in tests.
#pragma once
#include <memory>
#include <vector>

#include "cuda/math/node4.h"
#include "cuda/mpm/particle.h"
#include "host/solver/editable_simulator.h"

namespace knead {

// One substep of `dt` [s], equal to the frame, with the tools moving along `motion`. Errors as of
// gpu_solver().
class GpuStages {
  public:
    GpuStages(const Setup& setup, const Motion& motion, double dt);
    ~GpuStages();

    // Sorts the particles by cell; returns their ids in the new order.
    std::vector<int> sort();
    // The current particles, by id.
    std::vector<Particle<double>> particles();
    // Momentum and mass of every node, by Lattice::index; converted from fixed point if
    // Setup::deterministic.
    std::vector<Node<float>> p2g();
    // Velocity of every node, from momenta and masses by Lattice::index.
    std::vector<Node<float>> grid(const std::vector<Node<float>>& sums);
    // The particles after gathering these velocities, by id.
    std::vector<Particle<double>> g2p(const std::vector<Node<float>>& velocities);
    // Candidate primitives of every block of the lattice.
    std::vector<Mask> masks();
    // Order of the runs of particles.
    std::vector<int> lined_up();

  private:
    struct State;
    std::unique_ptr<State> state;
};

}  // namespace knead
