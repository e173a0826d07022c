// Hands from less than 26 joints: a hand posed around a controller, and radii where a tracker knows
// none.
#pragma once
#include "host/hands/hands.h"

namespace knead::xr {

// The hand whose palm is at an OpenXR grip pose: open at 0, its index and thumb closed by `trigger`
// and the other fingers by `grasp`, 1 being a fist.
Hand hand_around(Side side, const Joint<float>& grip, float trigger, float grasp);

// Puts radii of the default hand, at the size of this hand's fingers, where the tracker gives the
// same to all joints, none, or impossible ones.
void complete_radii(Hand& hand, Side side);

}  // namespace knead::xr
