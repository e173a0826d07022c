// Clay that two tools hold between them: no projection can bring it out.
#pragma once
#include <vector>

#include "host/solver/solver.h"

namespace knead {

// Depths [m] of the particles inside of a tool whose way out (19) ends inside of another, with the
// tools where `motion` ends. Blades are no bodies, and do not count.
std::vector<double> depths_between(const Setup& setup, const Motion& motion,
                                   const std::vector<Particle<double>>& particles);

}  // namespace knead
