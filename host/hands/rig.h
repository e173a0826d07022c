// How a medial hand is put together: which spheres, where they start, what spans them, and how a
// sphere fitted to the open hand hangs on its joints.
#pragma once
#include "host/hands/hands.h"

namespace knead {

// Where a sphere starts before it is fitted: at share s of the way from joint a to joint b.
struct Seed {
    JointName a, b;
    double s;
};

struct Layout {
    std::vector<Seed> spheres;
    std::vector<Primitive> primitives;
};

// H25: a sphere per joint but the palm, 14 cones, 12 slabs. H47: with the middles of the bones and
// the webs between the fingers, 23 cones, 31 slabs.
Layout layout(Topology topology);

// A sphere of the right hand in the frame of open_hand, and what it hangs on.
struct FittedSphere {
    Vec3<float> c;    // [m]
    float r;          // [m]
    int joint[4];     // JointName; unused ones repeat the first, with weight 0
    float weight[4];  // sum 1; the first is the largest
};

// What of a tool (tool_rig()) a hand is closed about; it is seen, and touches nothing. Empty where
// the tool itself lies in the hand. Throws std::invalid_argument for a tool that is not known.
Rig tool_handle(const std::string& name, Side side);

// Binds spheres of the right hand to the joints of `open`, the open hand of `side`.
Rig hang(const std::vector<FittedSphere>& spheres, const std::vector<Primitive>& primitives,
         const Hand& open, Side side);

}  // namespace knead
