#include "xr/hand_shape.h"

#include <algorithm>
#include <cmath>

#include "cuda/math/rotation.h"
#include "host/hands/posture.h"

namespace knead::xr {
namespace {

// The palm's frame as seen from the grip's. A grip's -z runs through the closed fingers towards the
// thumb, its x out of the back of the right hand and into that of the left.
Quat<double> palm_in_grip(Side side)
{
    const double s = side == right ? 1 : -1;
    return quaternion(Mat3<double>{{0, 0, s}, {s, 0, 0}, {0, 1, 0}});
}

// From the wrist over the palm to the middle finger's tip [m]; 0 where that is not known.
double reach(const Hand& hand)
{
    constexpr JointName chain[] = {wrist, middle_proximal, middle_intermediate, middle_distal,
                                   middle_tip};
    double sum = 0;
    for (int k = 0; k < 5; ++k) {
        if (!hand.valid[chain[k]]) return 0;
        if (k > 0) sum += length(hand.joints[chain[k]].p - hand.joints[chain[k - 1]].p);
    }
    return std::isfinite(sum) ? sum : 0;
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
    // The wrist, as the palm's frame sees it.
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
    constexpr float thickest = 0.05f, same = 1e-5f;  // [m]
    float low = thickest, high = 0;
    bool sound = true;
    for (int j = 0; j < joint_count; ++j) {
        if (!hand.valid[j]) continue;
        const float r = hand.radius[j];
        sound = sound && r > 0 && r < thickest;  // false for what is no number
        low = std::min(low, r), high = std::max(high, r);
    }
    if (sound && high - low > same) return;
    const Hand usual = open_hand(side);
    const double size = reach(hand) / reach(usual);
    const float scale = size > 0.5 && size < 2 ? float(size) : 1;
    for (int j = 0; j < joint_count; ++j) hand.radius[j] = scale * usual.radius[j];
}

}  // namespace knead::xr
