// A GPU solver with a given size of the stored box (stored_region.h): for tests at its boundary.
#pragma once
#include <memory>

#include "host/solver/editable_simulator.h"

namespace knead {

struct RegionPadding {
    int spare = -1;       // nodes around the clay at first, plus a block; -1: by the extent of the
                          // clay
    std::size_t max = 0;  // nodes beyond which allocation fails; 0: device memory only
};
constexpr RegionPadding whole_lattice{1 << 30, 0};
std::unique_ptr<EditableSimulator> gpu_solver(const Setup& setup, int device, RegionPadding room);

}  // namespace knead
