// Clay pinched between two tools: no projection can move it out.
#pragma once
#include <vector>

#include "host/solver/simulator.h"

namespace knead {

// Depths [m] of particles inside a tool whose projection (19) ends inside another tool. Tools are
// posed at the end of `motion`. Blades are ignored.
std::vector<double> depths_between(const SimulationConfig& setup, const Motion& motion,
                                   const std::vector<Particle<double>>& particles);

}  // namespace knead
