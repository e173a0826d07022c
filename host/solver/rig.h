// Geometry that moves with joints and touches the clay.
#pragma once
#include <algorithm>
#include <vector>

#include "cuda/contact/skinning.h"

namespace knead {

// Spheres bound to joints, and the primitives they span. Joint indices are those of the motion.
// Primitive::tool is 0 until the rig is placed in a scene.
struct Rig {
    std::vector<Binding<float>> spheres;
    std::vector<Primitive> primitives;
};

// Per sphere, the tool of its primitives.
inline std::vector<int> tools_of_spheres(const Rig& rig)
{
    std::vector<int> tools(rig.spheres.size(), 0);
    for (const Primitive& p : rig.primitives)
        for (int k = 0; k < p.count; ++k) tools[std::size_t(p.sphere[k])] = p.tool;
    return tools;
}

// Number of joints that a motion must have: highest bound index plus one.
inline int joints_of(const Rig& rig)
{
    int count = 0;
    for (const Binding<float>& sphere : rig.spheres)
        for (int joint : sphere.joint) count = std::max(count, joint + 1);
    return count;
}

}  // namespace knead
