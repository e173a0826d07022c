// Blades: tools thinner than the lattice can see, treated from both sides.
#pragma once
#include "contact.h"

namespace knead {

// How far from a blade its sides are kept, in cells.
constexpr int blade_reach = 3;

}  // namespace knead
