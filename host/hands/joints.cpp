// Joint names, and the joint poses of the open hand.
#include "host/hands/hands.h"
#include "host/hands/rig_table.h"

namespace knead {

const char* const joint_names[joint_count] = {"palm",
                                              "wrist",
                                              "thumb_metacarpal",
                                              "thumb_proximal",
                                              "thumb_distal",
                                              "thumb_tip",
                                              "index_metacarpal",
                                              "index_proximal",
                                              "index_intermediate",
                                              "index_distal",
                                              "index_tip",
                                              "middle_metacarpal",
                                              "middle_proximal",
                                              "middle_intermediate",
                                              "middle_distal",
                                              "middle_tip",
                                              "ring_metacarpal",
                                              "ring_proximal",
                                              "ring_intermediate",
                                              "ring_distal",
                                              "ring_tip",
                                              "little_metacarpal",
                                              "little_proximal",
                                              "little_intermediate",
                                              "little_distal",
                                              "little_tip"};

Hand open_hand(Side side)
{
    Hand hand;
    hand.tracked = true;
    for (int j = 0; j < joint_count; ++j) {
        const OpenJoint& open = open_joints[j];
        const Joint<float> joint{unit(open.q), open.p};
        hand.joints[j] = side == right ? joint : mirrored(joint);
        hand.radius[j] = open.radius;
        hand.valid[j] = true;
    }
    return hand;
}

}  // namespace knead
