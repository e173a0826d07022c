// Primitives of tools for drawing.
#pragma once
#include <vector>

#include "host/solver/simulator.h"
#include "render/painter.h"

namespace knead {

// The primitives of one tool of a rig at the end of a motion; none without a motion.
std::vector<DrawPrimitive> draw_primitives(const Rig& rig, const Motion& motion, int tool);

}  // namespace knead
