#include "host/hands/pointer.h"

#include <algorithm>
#include <cmath>

#include "cuda/math/rotation.h"

namespace knead {
namespace {

Vec3<double> unit_vector(Vec3<double> v) { return (1 / length(v)) * v; }

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

// Steepness of the fingers on the surface [rad]. A tool is an extension of the forearm.
double steepness(Posture posture, bool bare)
{
    if (!bare) return 1.1;
    switch (posture) {
        case Posture::open:
        case Posture::relaxed:
            return 0.5;
        case Posture::pointing:
        case Posture::pinch:
            return 0.8;
        case Posture::fist:
            break;
    }
    return 1.0;
}

// The point of the tool that is foremost in this direction (unit), relative to the wrist.
Vec3<double> foremost(const Rig& rig, const Pose& pose, Side side, Vec3<double> direction)
{
    Vec3<double> best{};
    double most = -1e30;
    for (const Binding<float>& bound : rig.spheres) {
        const Binding<double> b = cast<double>(bound);
        const Vec3<double> c = centre(b, [&](int j) { return pose[j - int(side) * joint_count]; });
        const Vec3<double> tip = c + b.radius * direction;
        if (dot(tip, direction) > most) most = dot(tip, direction), best = tip;
    }
    return best;
}

}  // namespace

const char* const posture_names[posture_count] = {"open", "relaxed", "pointing", "pinch", "fist"};

void PointerHand::aim(const Pointing& at)
{
    if (presses()) {
        target_ = at.eye + depth_ * at.ray;
        return;
    }
    const Vec3<double> gaze = rotate(at.rotation, Vec3<double>{0, 0, -1});
    if (at.on) depth_ = dot(at.on->at - at.eye, gaze);
    target_ = at.eye + depth_ * at.ray;
    const Vec3<double> along = unit_vector(at.ray);
    // Between the line of sight and the surface's normal: at the clay's outline, too, the hand
    // stays in front of it.
    inward_ = at.on ? unit_vector(along - at.on->normal) : along;
    const Vec3<double> right = rotate(at.rotation, Vec3<double>{1, 0, 0}),
                       up = rotate(at.rotation, Vec3<double>{0, 1, 0});
    // The side changes only well beyond the middle, not at every move across it.
    const double off = dot(at.eye + dot(at.middle - at.eye, gaze) * at.ray - at.middle, right);
    const double wide = 0.08 * length(at.middle - at.eye);
    if (off > wide) from_ = 1;
    if (off < -wide) from_ = -1;
    const Vec3<double> arm = from_ * right - 0.7 * up;  // from the fingertips to the wrist
    const Vec3<double> flat = arm - dot(arm, inward_) * inward_;
    if (length(flat) > 1e-6) fingers_ = -1.0 * unit_vector(flat);
}

void PointerHand::advance(double time)
{
    const double by = began_ ? std::clamp(time - time_, 0.0, 1.0) : 0;
    time_ = time;
    began_ = true;
    pressing_ = pressed || (pressing_ && share_ < 1);
    if (pressing_) {
        shown_ += std::max(by, 1e-9);
        if (shown_ > appear_time)
            share_ = std::min(1.0, share_ + std::min(by, shown_ - appear_time) / press_time);
    } else if (presses()) {
        share_ = std::max(0.0, share_ - by / press_time);
        if (share_ == 0) shown_ = 0;
    }
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

HandFrame PointerHand::hands(const HandsOptions& options) const
{
    const std::string& held = options.held[side];
    const Rig rig = held.empty() ? hand_rig(options.topology, side) : tool_rig(held, side);
    // In the wrist's frame the fingers point along -z, the back of the hand along y.
    const double steep = std::clamp(steepness(posture, held.empty()) + tilt, 0.0, 1.57);
    const Vec3<double> flat = rotate(turn_about(inward_, roll), fingers_);
    const Vec3<double> forward = std::cos(steep) * flat + std::sin(steep) * inward_;
    const Vec3<double> back = std::sin(steep) * flat - std::cos(steep) * inward_;
    const Vec3<double> z = -1.0 * forward, x = cross(back, z);
    const Quat<double> turn = quaternion(Mat3<double>{x, back, z});
    const Fingers bent = fingers();
    const Vec3<double> tip = foremost(rig, posed(side, {turn, {0, 0, 0}}, bent), side, inward_);
    // Minimum jerk, from rest to rest. [Flash and Hogan 1985]
    const double s = share_, eased = s * s * s * (10 + s * (6 * s - 15));
    const Vec3<double> seen = target_ + (eased * (press + gap) - gap) * inward_;
    const Vec3<double> point = (1 / options.zoom) * (seen - options.at);
    const Pose pose = posed(side, {turn, point - tip}, bent);

    HandFrame frame;
    frame.time = time_;
    Hand& hand = frame.hand[side];
    hand = open_hand(side);
    hand.tracked = presses();
    hand.valid.fill(true);
    for (int j = 0; j < joint_count; ++j) hand.joints[j] = cast<float>(pose[j]);
    return frame;
}

}  // namespace knead
