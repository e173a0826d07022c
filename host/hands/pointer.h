// A hand that a mouse leads when none is tracked. Over clay it lies along the surface below the
// pointer, with the forearm to the side, so that it does not hide what it presses; a press moves it
// into the clay. Its output has the form of a tracked hand.
#pragma once
#include <optional>

#include "host/hands/hands_options.h"
#include "host/hands/posture.h"

namespace knead {

enum class Posture { open, relaxed, pointing, pinch, fist };
constexpr int posture_count = 5;
extern const char* const posture_names[posture_count];

// A point of the clay's surface, in the simulation's frame.
struct SurfacePoint {
    Vec3<double> at{};             // [m]
    Vec3<double> normal{0, 1, 0};  // unit, outward
};

// Pointing ray of the mouse. Axes of the eye: x right, y up, gaze along -z.
struct Pointing {
    Vec3<double> eye{};                 // in the simulation's frame [m]
    Quat<double> rotation{1, 0, 0, 0};  // unit; orientation of the eye
    Vec3<double> ray{};                 // through the mouse; its component along the gaze is 1
    std::optional<SurfacePoint> on{};   // what the ray hits first; none: no clay
    Vec3<double> middle{};              // of what is looked at [m]
};

class PointerHand {
  public:
    static constexpr double appear_time = 0.2;  // start-up time of the hand filter [s]
    static constexpr double press_time = 0.25;  // of the way in, and of the way out [s]

    Side side = right;
    Posture posture = Posture::relaxed;
    double curl[5] = {0, 0, 0, 0, 0};  // added to the posture, fraction of a fist; 0: thumb
    double tilt = 0;                   // positive: fingers steeper [rad]
    double roll = 0;                   // about the direction of the press [rad]
    double press = 0.05;               // depth, in the simulation's frame [m]
    double gap = 0.03;                 // beside the surface before and after a press, likewise [m]
    bool pressed = false;              // the button is down

    // Aims at the surface. During a press the target follows the pointer at a fixed depth along the
    // gaze, and the direction of the press is fixed.
    void aim(const Pointing& at);
    // Advances to `time` [s]. A press is completed even if the button was down for an instant only.
    void advance(double time);
    // Ends a press at once.
    void cancel() { pressing_ = false, share_ = shown_ = 0; }
    // From the button's press to the end of the way out.
    bool presses() const { return shown_ > 0; }

    Fingers fingers() const;
    // Both hands at the time of the last advance(), in the tracker's frame of the options, which
    // maps to the simulation's frame by at + zoom * p. The other hand is untracked, and so is this
    // one except during a press, so that its motion between places does not deform clay. Its joints
    // are valid all the time.
    HandFrame hands(const HandsOptions& options) const;
    // Where it points, and the direction of a press (unit), in the simulation's frame.
    Vec3<double> target() const { return target_; }
    Vec3<double> direction() const { return inward_; }

  private:
    double time_ = 0;  // [s]
    bool began_ = false;
    bool pressing_ = false;
    double share_ = 0;  // progress of the press, 0 to 1
    double shown_ = 0;  // time since the press began [s]; 0: no press
    Vec3<double> target_{}, inward_{0, 0, -1};
    Vec3<double> fingers_{-1, 0, 0};  // unit, along the surface: to the fingertips
    double depth_ = 1;                // of the target along the gaze [m]
    double from_ = 1;  // side of the picture the forearm comes from: 1 right, -1 left
};

}  // namespace knead
