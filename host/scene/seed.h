// Creates particles, rig and tools from objects and hands: the parts of build() in scene.h, with
// estimates of count and memory.
#pragma once
#include <vector>

#include "host/scene/scene.h"
#include "host/scene/shapes.h"

namespace knead {

double expected_particles(const Scene& scene);  // overlaps counted twice
double expected_bytes(const Scene& scene);      // host and solver

// Rig and tools of the hands, at their size in the simulation.
struct HandTools {
    Rig rig;
    std::vector<Tool<double>> tools;
};
// Throws std::invalid_argument for an unknown tool.
HandTools hand_tools(const HandsOptions& hands);

}  // namespace knead
