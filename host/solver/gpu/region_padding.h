// A solver on the device that stores more or fewer nodes than it would (stored_region.h): for tests
// of what happens at their ends.
#pragma once
#include <memory>

#include "host/solver/solver.h"

namespace knead {

struct RegionPadding {
    int spare = -1;       // nodes around the clay at first, and a block; -1: as the clay is large
    std::size_t max = 0;  // nodes until asking the device for more fails; 0: as it has
};
constexpr RegionPadding whole_lattice{1 << 30, 0};
std::unique_ptr<Solver> gpu_solver(const Setup& setup, int device, RegionPadding room);

}  // namespace knead
