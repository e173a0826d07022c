// Clay and tools: clay pinched between two tools, which no projection can move out, and tools that
// are inside clay.
#pragma once
#include <vector>

#include "host/solver/simulator.h"

namespace knead {

// Depths [m] of particles inside a tool whose projection (19) ends inside another tool. Tools are
// posed at the end of `motion`. Blades are ignored.
std::vector<double> depths_between(const SimulationConfig& setup, const Motion& motion,
                                   const std::vector<Particle<double>>& particles);

// Per tool, whether a particle is inside it, as posed at the end of `motion` with `size` times its
// radii. Blades: never. Precondition: no frame in flight.
std::vector<char> tools_in_clay(const SimulationConfig& config, const Motion& motion,
                                const Simulator& simulator, float size = 1);

}  // namespace knead
