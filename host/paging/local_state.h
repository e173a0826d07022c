// All that decides what becomes of a scene with local clay, beside its solver and the splats that
// move: for checkpoints.
#pragma once
#include <cstdint>
#include <map>
#include <vector>

#include "host/splats/cloud.h"

namespace knead {

struct LocalState {
    SplatCloud cloud;                  // slots
    std::vector<char> active;          // each: its splat moves
    std::vector<Vec3<float>> normal;   // each: outward, 0 where it is not known yet
    std::vector<int> slot_of;          // of each moving splat, its slot; -1: none
    std::map<std::int64_t, int> clay;  // cubes that are clay, and their objects; -1: empty ones
    int objects = 0;                   // that the solver has had; those not in `clay` are removed
};

// Throws std::invalid_argument where it is not whole.
void check(const LocalState& state);

}  // namespace knead
