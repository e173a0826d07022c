// From objects and hands to particles, rig and tools: what build() of scene.h needs, and how much.
#pragma once
#include <vector>

#include "host/scene/scene.h"

namespace knead {

double shape_volume(const Object& object);      // [m^3]
double expected_particles(const Scene& scene);  // before overlaps are left out
double expected_bytes(const Scene& scene);      // host and solver together

// What the hands are, or hold, in the size that they have in the simulation.
struct HandTools {
    Rig rig;
    std::vector<Tool<double>> tools;
};
// Throws std::invalid_argument for a tool that is not known.
HandTools hand_tools(const HandsOptions& hands);

// How far under an object's surface x lies [m], negative outside; never inside of shape `splats`.
double depth(const Object& object, Vec3<double> x);
bool inside(const Object& object, Vec3<double> x);

}  // namespace knead
