// A hand controlled by mouse and keys when none is tracked. It follows the mouse pointer, reaches
// in from below and from its own side, so that it occludes little, and takes its posture from keys.
// Its output has the form of a tracked hand.
#pragma once
#include "host/hands/hands_options.h"
#include "host/hands/posture.h"

namespace knead {

enum class Posture { open, relaxed, pointing, pinch, fist };
constexpr int posture_count = 5;
extern const char* const posture_names[posture_count];

// Pointing ray of the mouse. Axes of the eye: x right, y up, gaze along -z.
struct Pointing {
    Vec3<double> eye{};                 // in the simulation's frame [m]
    Quat<double> rotation{1, 0, 0, 0};  // unit; orientation of the eye
    Vec3<double> ray{};                 // through the mouse; its component along the gaze is 1
};

class PointerHand {
  public:
    Side side = right;
    Posture posture = Posture::relaxed;
    double curl[5] = {0, 0, 0, 0, 0};  // added to the posture, fraction of a fist; 0: thumb
    double tilt = 0;                   // positive: fingers down [rad]
    double roll = 0;                   // clockwise in view [rad]
    double reach = 1;                  // distance of the foremost point along the gaze [m]
    double press = 0.1;                // added while the button is down, in real metres
    bool pressed = false;

    // Advances to `time` [s]. Pressing and releasing take 0.25 s each, so that the tool does not
    // jump.
    void advance(double time);
    Fingers fingers() const;
    // Both hands at the time of the last advance(), in the tracker's frame of the options, which
    // maps to the simulation's frame by at + zoom * p. The other hand is untracked.
    HandFrame hands(const Pointing& pointing, const HandsOptions& options) const;

  private:
    double time_ = 0;  // [s]
    bool began_ = false;
    double share_ = 0;  // progress of the press, 0 to 1
};

}  // namespace knead
