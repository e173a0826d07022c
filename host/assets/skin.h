// A skinned hand mesh in the frame of open_hand: the target of the medial hand's fit.
#pragma once
#include <string>
#include <vector>

#include "host/hands/hands.h"

namespace knead {

struct Skin {
    std::vector<Vec3<double>> vertices;  // bind pose, wrist at the origin, fingers along -z [m]
    std::vector<Int3> triangles;         // vertex indices
    std::vector<std::array<double, joint_count>> weights;  // per vertex, sum 1
    std::array<Joint<double>, joint_count> joints;         // bind pose: docs/method/hands.md
};

// Reads a binary glTF whose skin has the 25 joints of the WebXR Hand Input specification, by name.
// Throws InputError with the path, expected and found.
Skin read_skin(const std::string& path);

// A surface point with its joint weights (linear blend skinning).
struct SkinPoint {
    Vec3<double> p;                          // bind pose [m]
    std::array<double, joint_count> weight;  // sum 1
};

// `count` points spread evenly over the area, deterministic. The open end at the wrist (the last 12
// % of the length) is left out: a union of balls necessarily bulges there.
std::vector<SkinPoint> spread(const Skin& skin, int count);

// Position of the point by linear blend skinning for the joints at `pose`.
Vec3<double> follow(const Skin& skin, const SkinPoint& point,
                    const std::array<Joint<double>, joint_count>& pose);

// The mesh of the other hand: x negated.
Skin mirrored(const Skin& skin);

}  // namespace knead
