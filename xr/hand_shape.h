// Hands from incomplete data: a hand posed around a controller, and radii that a tracker lacks.
#pragma once
#include "host/hands/hands.h"

namespace knead::xr {

// A hand with its palm at an OpenXR grip pose. `trigger` closes thumb and index, `grasp` the other
// fingers: 0 open, 1 fist.
Hand hand_around(Side side, const Joint<float>& grip, float trigger, float grasp);

// Replaces the radii by those of the default hand, scaled to this hand's bones, if the tracker's
// are missing, all equal or impossible.
void complete_radii(Hand& hand, Side side);

}  // namespace knead::xr
