// Clay as a solver has it on the device: the ball of ball.h, in motion and under strain, in the
// order of its cells.
#pragma once
#include "cuda/mpm/stages.cuh"
#include "cuda/mpm/stencil.h"
#include "host/bench/ball.h"
#include "host/solver/gpu/store.cuh"
#include "profiling/micro/bench.cuh"

namespace knead::micro {

enum class Order {
    by_cell,
    drifted,  // by cell, but every particle has since moved by half a cell along each axis, at most
    by_block,  // of 4 x 4 x 4 cells, in any order within
    none
};

class Clay {
  public:
    // Nodes along each axis of the ball's box; whether equal bits are asked for.
    Clay(int nodes, Order order, cudaStream_t stream, bool deterministic = false);

    gpu::Store& store() { return memory; }
    const gpu::Views& views() const { return seen; }
    int count() const { return seen.particles[0].count; }
    float dt() const { return step; }
    int parity() const { return clock.done & 1; }
    double mass() const { return double(count()) * setup.materials[0].mass; }
    const Features& features() const { return used; }

    // As before the first scatter: no mass on any node. Waits for the device.
    void clear();
    // Nodes of the current grid.
    std::vector<float4> nodes() const;

  private:
    Setup setup;
    gpu::Store memory;
    gpu::Views seen;
    Features used;
    gpu::Clock clock{};
    float step = 0;
};

// The scene alone.
Setup moving_ball(int nodes, Order order, bool deterministic = false);

}  // namespace knead::micro
