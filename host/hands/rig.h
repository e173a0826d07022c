// Construction of a medial hand: its spheres, their initial positions, the primitives between them,
// and the binding of fitted spheres to joints.
#pragma once
#include "host/hands/hands.h"

namespace knead {

// Initial position of a sphere before fitting: at fraction s of the way from joint a to joint b.
struct Seed {
    JointName a, b;
    double s;
};

struct Layout {
    std::vector<Seed> spheres;
    std::vector<Primitive> primitives;
};

// H25: a sphere per joint except the palm, 14 cones, 12 slabs. H47: in addition the middles of the
// bones and the webs between the fingers, 23 cones, 31 slabs.
Layout layout(Topology topology);

// A sphere of the right hand in the frame of open_hand, and its joint weights.
struct FittedSphere {
    Vec3<float> c;    // [m]
    float r;          // [m]
    int joint[4];     // JointName; unused ones repeat the first, with weight 0
    float weight[4];  // sum 1; the first is the largest
};

// Handle of a tool (tool_rig()) around which a hand is closed; drawn only, without contact. Empty
// if the hand holds the tool itself. Throws std::invalid_argument for an unknown tool.
Rig tool_handle(const std::string& name, Side side);

// Binds spheres of the right hand to the joints of `open`, the open hand of `side`; mirrored for
// the left.
Rig hang(const std::vector<FittedSphere>& spheres, const std::vector<Primitive>& primitives,
         const Hand& open, Side side);

}  // namespace knead
