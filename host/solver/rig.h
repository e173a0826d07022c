// What moves with joints and touches the clay.
#pragma once
#include <vector>

#include "cuda/contact/skinning.h"

namespace knead {

// Spheres bound to joints, and the primitives they span. Joints are numbered as in the
// motion that moves them. Primitive::tool is 0 within a rig until it is placed in a scene.
struct Rig {
    std::vector<Binding<float>> spheres;
    std::vector<Primitive> primitives;
};

}  // namespace knead
