#include "host/hands/pointer.h"

#include <algorithm>
#include <cmath>

namespace knead {
namespace {

constexpr double press_time = 0.25;  // [s]

Fingers posed_as(Posture posture, Side side)
{
    Fingers f{};
    switch (posture) {
        case Posture::open:
            return f;
        case Posture::relaxed:
            return gripped(0.2);
        case Posture::pointing:
            f = gripped(0.9);
            for (double& angle : f.flex[1]) angle = 0.05;
            return f;
        case Posture::pinch: {
            static const Fingers of[side_count] = {pinched(left), pinched(right)};
            return of[side];
        }
        case Posture::fist:
            break;
    }
    return gripped(1);
}

// The point of the tool that is foremost along the gaze, relative to the wrist.
Vec3<double> foremost(const Rig& rig, const Pose& pose, Side side)
{
    Vec3<double> best{0, 0, 1e30};
    for (const Binding<float>& bound : rig.spheres) {
        const Binding<double> b = cast<double>(bound);
        const Vec3<double> c = centre(b, [&](int j) { return pose[j - int(side) * joint_count]; });
        const Vec3<double> tip{c.x, c.y, c.z - b.radius};
        if (tip.z < best.z) best = tip;
    }
    return best;
}

}  // namespace

const char* const posture_names[posture_count] = {"open", "relaxed", "pointing", "pinch", "fist"};

void PointerHand::advance(double time)
{
    const double by = began_ ? std::clamp(time - time_, 0.0, 1.0) / press_time : 0;
    share_ = std::clamp(share_ + (pressed ? by : -by), 0.0, 1.0);
    time_ = time;
    began_ = true;
}

Fingers PointerHand::fingers() const
{
    Fingers f = posed_as(posture, side);
    const Fingers fist = gripped(1);
    for (int i = 0; i < 5; ++i)
        for (int k = 0; k < 3; ++k)
            f.flex[i][k] += std::clamp(curl[i], 0.0, 1.0) * (fist.flex[i][k] - f.flex[i][k]);
    return within_limits(f);
}

HandFrame PointerHand::hands(const Pointing& at, const HandsOptions& options) const
{
    const Quat<double> turn =
        turn_about(Vec3<double>{0, 0, 1}, -roll) * turn_about(Vec3<double>{1, 0, 0}, -tilt);
    const Fingers bent = fingers();
    const Pose there = posed(side, {turn, {0, 0, 0}}, bent);
    const std::string& held = options.held[side];
    const Rig rig = held.empty() ? hand_rig(options.topology, side) : tool_rig(held, side);
    const Vec3<double> tip = foremost(rig, there, side);
    // Minimum jerk, from rest to rest. [Flash and Hogan 1985]
    const double s = share_, eased = s * s * s * (10 + s * (6 * s - 15));
    const double far = reach + eased * press * options.zoom;
    const Vec3<double> seen = at.eye + far * at.ray;
    const Vec3<double> point = (1 / options.zoom) * (seen - options.at);
    const Joint<double> wrist_at{unit(at.rotation * turn), point - rotate(at.rotation, tip)};
    const Pose pose = posed(side, wrist_at, bent);

    HandFrame frame;
    frame.time = time_;
    Hand& hand = frame.hand[side];
    hand = open_hand(side);
    hand.tracked = true;
    hand.valid.fill(true);
    for (int j = 0; j < joint_count; ++j) hand.joints[j] = cast<float>(pose[j]);
    return frame;
}

}  // namespace knead
