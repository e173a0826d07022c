// A hand posed by finger angles, and the distance of a rig from a ball.
#pragma once
#include <array>

#include "host/hands/hands.h"

namespace knead {

// Joint angles relative to open_hand() [rad]. Finger 0 is the thumb. Flexion rotates a joint about
// its local -x, towards the palm; spread rotates the finger's root about its local y, away from the
// middle of the hand for positive angles on either side.
struct Fingers {
    double flex[5]
               [3];  // thumb: metacarpal, proximal, distal; others: proximal, intermediate, distal
    double spread[5];
};
Fingers between(const Fingers& from, const Fingers& to, double s);
// Clamps the angles to the range of a healthy hand (Kapandji, "The Physiology of the Joints", vol.
// 1, rounded).
Fingers within_limits(Fingers fingers);

using Pose = std::array<Joint<double>, joint_count>;
// All joints, by forward kinematics from the wrist over the bones of open_hand(side).
Pose posed(Side side, const Joint<double>& wrist_at, const Fingers& fingers);

// Postures. `wrapped` lays each finger around a ball of `radius` [m]; `pinched` brings the pads of
// thumb and index together, the others curled; `gripped` closes the hand to `share` of a fist.
Fingers wrapped(Side side, double radius);
Fingers pinched(Side side);
Fingers gripped(double share);

// Signed distance [m] between a rig and the ball: negative is the deepest penetration. Exact if no
// medial primitive contains the ball's centre, because the primitives are convex. `joints`: the
// joints of both hands, concatenated.
double gap(const Rig& rig, const Joint<double> joints[2 * joint_count], Vec3<double> centre,
           double radius);

}  // namespace knead
