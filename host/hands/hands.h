// Tracked hands: 26 OpenXR joints each, time-stamped, unfiltered; and the rigs of hands and tools
// that move the medial spheres.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "host/solver/rig.h"

namespace knead {

// XrHandJointEXT, in its order.
enum JointName : int {
    palm,
    wrist,
    thumb_metacarpal,
    thumb_proximal,
    thumb_distal,
    thumb_tip,
    index_metacarpal,
    index_proximal,
    index_intermediate,
    index_distal,
    index_tip,
    middle_metacarpal,
    middle_proximal,
    middle_intermediate,
    middle_distal,
    middle_tip,
    ring_metacarpal,
    ring_proximal,
    ring_intermediate,
    ring_distal,
    ring_tip,
    little_metacarpal,
    little_proximal,
    little_intermediate,
    little_distal,
    little_tip,
    joint_count
};
extern const char* const joint_names[joint_count];  // as spelled above

enum Side : int { left, right, side_count };

// One hand at one instant, in the tracker's frame: metres, y up, real size.
struct Hand {
    bool tracked = false;  // false: joints hold their last known poses
    std::array<Joint<float>, joint_count> joints{};
    std::array<float, joint_count> radius{};  // joint to skin [m], as reported by the tracker
    std::array<bool, joint_count> valid{};
};
struct HandFrame {
    double time = 0;  // since the start of the recording, increasing [s]
    Hand hand[side_count];
};

// A recording: unfiltered frames of both hands.
struct Recording {
    std::string name;    // name of the gesture, e.g. "squeeze"
    double rate = 0;     // nominal frames per second
    double latency = 0;  // of the tracker, already compensated in the time stamps [s]
    std::vector<HandFrame> frames;
};

enum class Topology { h25, h47 };

// In a rig of hands, joint j of side s has index s * joint_count + j.
Rig hand_rig(Topology topology, Side side);

// The tools that a hand can hold: "slab", "rod", "cone", "ball", "knife", "scissors".
std::vector<std::string> tool_names();
// The tool of that name, fixed to a joint of `side`. Throws std::invalid_argument for another name.
Rig tool_rig(const std::string& name, Side side);

// A neutral open hand, palm down, fingers along -z, wrist at the origin: real size.
Hand open_hand(Side side);

// The joint of the other hand: the reflection in x = 0, its frame kept right-handed. Flexion about
// local x keeps its sign.
template <class R>
Joint<R> mirrored(const Joint<R>& j)
{
    return {{j.q.w, j.q.x, -j.q.y, -j.q.z}, {-j.p.x, j.p.y, j.p.z}};
}

}  // namespace knead
