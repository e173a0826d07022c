// From objects and hands to particles, rig and tools: what build() of scene.h needs, and how much.
#pragma once
#include <vector>

#include "host/scene/scene.h"

namespace knead {

double shape_volume(const Object& object);             // [m^3]
double expected_particles(const Scene& scene);         // before overlaps are left out
double expected_bytes(const Scene& scene);             // host and solver together
std::vector<Side> tool_sides(const HandsRule& hands);  // of each tool, in its order
bool inside(const Object& object, Vec3<double> x);     // x in [m]; never of shape `splats`
std::size_t available_memory();                        // bytes free on this machine

}  // namespace knead
