#include "xr/hand_shape.h"

#include <algorithm>
#include <cmath>

#include "cuda/math/rotation.h"
#include "host/hands/hand_size.h"
#include "host/hands/posture.h"

namespace knead::xr {
namespace {

// Rotation from the palm's frame to the grip's. The grip's -z axis runs through the closed fingers
// towards the thumb, its x axis out of the back of the right hand and into that of the left.
Quat<double> palm_in_grip(Side side)
{
    const double s = side == right ? 1 : -1;
    return quaternion(Mat3<double>{{0, 0, s}, {s, 0, 0}, {0, 1, 0}});
}

}  // namespace

Hand hand_around(Side side, const Joint<float>& grip, float trigger, float grasp)
{
    const auto held = [](float value) { return std::isfinite(value) ? clamp(value, 0.f, 1.f) : 0; };
    const Fingers index = gripped(held(trigger)), others = gripped(held(grasp));
    Fingers fingers = others;
    for (int finger = 0; finger < 2; ++finger)
        std::copy(index.flex[finger], index.flex[finger] + 3, fingers.flex[finger]);

    Hand hand = open_hand(side);
    const Quat<double> q = unit(unit(cast<double>(grip.q)) * palm_in_grip(side));
    // The wrist in the palm's frame.
    const Joint<double> of_wrist{unit(cast<double>(hand.joints[wrist].q)),
                                 cast<double>(hand.joints[wrist].p)};
    const Joint<double> of_palm{unit(cast<double>(hand.joints[palm].q)),
                                cast<double>(hand.joints[palm].p)};
    const Quat<double> back = conjugate(of_palm.q);
    const Joint<double> at{unit(q * (back * of_wrist.q)),
                           cast<double>(grip.p) + rotate(q, rotate(back, of_wrist.p - of_palm.p))};
    const Pose pose = posed(side, at, fingers);
    for (int j = 0; j < joint_count; ++j)
        hand.joints[j] = {cast<float>(unit(pose[j].q)), cast<float>(pose[j].p)};
    hand.tracked = true;
    hand.valid.fill(true);
    return hand;
}

void complete_radii(Hand& hand, Side side)
{
    if (radii_known(hand)) return;
    const Hand usual = open_hand(side);
    const double size = bone_ratio(hand);
    const float scale = size > 0 ? float(size) : 1;
    for (int j = 0; j < joint_count; ++j) hand.radius[j] = scale * usual.radius[j];
}

}  // namespace knead::xr
