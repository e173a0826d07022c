// What moves with joints and touches the clay.
#pragma once
#include <algorithm>
#include <vector>

#include "cuda/contact/skinning.h"

namespace knead {

// Spheres bound to joints, and the primitives they span. Joints are numbered as in the
// motion that moves them. Primitive::tool is 0 within a rig until it is placed in a scene.
struct Rig {
    std::vector<Binding<float>> spheres;
    std::vector<Primitive> primitives;
};

// One more than the highest joint that any of its spheres hangs on.
inline int joints_of(const Rig& rig)
{
    int count = 0;
    for (const Binding<float>& sphere : rig.spheres)
        for (int joint : sphere.joint) count = std::max(count, joint + 1);
    return count;
}

}  // namespace knead
