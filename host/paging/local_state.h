// State of local clay for checkpoints. With the states of the solver and of the moving splats it
// determines the rest of a run.
#pragma once
#include <cstdint>
#include <map>
#include <vector>

#include "host/splats/cloud.h"

namespace knead {

struct LocalState {
    SplatCloud cloud;                  // a splat a slot
    std::vector<char> active;          // per slot: 1 if its splat is simulated
    std::vector<Vec3<float>> normal;   // per slot: outward, 0 if not computed yet
    std::vector<int> slot_of;          // per moving splat: its slot; -1: none
    std::map<std::int64_t, int> clay;  // active cubes and their objects; -1: empty
    int objects = 0;                   // created so far; those not in `clay` are removed
};

// Throws std::invalid_argument if array sizes, slots or object numbers are inconsistent.
void check(const LocalState& state);

}  // namespace knead
