// Creates particles, rig and tools from objects and hands: the parts of build() in scene.h, with
// estimates of count and memory.
#pragma once
#include <vector>

#include "cuda/math/box.h"
#include "host/scene/scene.h"

namespace knead {

// The smallest box along the axes that contains an object, rotated, and the lengths of its edges
// [m]. Of shape `splats`: what is loaded, or nothing.
Box3<double> box_of(const Object& object);
Vec3<double> extents(const Object& object);
double shape_volume(const Object& object);      // [m^3]
double expected_particles(const Scene& scene);  // overlaps counted twice
double expected_bytes(const Scene& scene);      // host and solver

// Rig and tools of the hands, at their size in the simulation.
struct HandTools {
    Rig rig;
    std::vector<Tool<double>> tools;
};
// Throws std::invalid_argument for an unknown tool.
HandTools hand_tools(const HandsOptions& hands);

// Depth of x below an object's surface [m], negative outside; always outside for shape `splats`.
double depth(const Object& object, Vec3<double> x);
bool inside(const Object& object, Vec3<double> x);

}  // namespace knead
