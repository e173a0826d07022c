// A hand for those who have none tracked: it hangs on a mouse, reaches in from below and its own
// side, so that it hides little of what it touches, and is posed by keys. What comes out is a
// tracked hand like any other.
#pragma once
#include "host/hands/hands_options.h"
#include "host/hands/posture.h"

namespace knead {

enum class Posture { open, relaxed, pointing, pinch, fist };
constexpr int posture_count = 5;
extern const char* const posture_names[posture_count];

// Where the mouse points: the axes of the eye are x right, y up, the gaze along -z.
struct Pointing {
    Vec3<double> eye{};                 // in the simulation [m]
    Quat<double> rotation{1, 0, 0, 0};  // unit; of the eye's axes
    Vec3<double> ray{};                 // through the mouse; as long as the gaze goes 1 ahead
};

class PointerHand {
  public:
    Side side = right;
    Posture posture = Posture::relaxed;
    double curl[5] = {0, 0, 0, 0, 0};  // beyond the posture, share of a fist; 0 is the thumb
    double tilt = 0;                   // fingers down for positive angles [rad]
    double roll = 0;                   // clockwise as the eye sees it [rad]
    double reach = 1;                  // how far ahead of the eye the foremost point is [m]
    double press = 0.1;                // how much farther while the button is down, in real metres
    bool pressed = false;

    // Goes on to `time` [s]: pressing in and letting go take 0.25 s each, so that the tool does not
    // jump.
    void advance(double time);
    Fingers fingers() const;
    // Both hands at the time of the last advance(), in the tracker's frame of the rule: the
    // simulation's is at + zoom * p. The other hand is not tracked.
    HandFrame hands(const Pointing& pointing, const HandsOptions& options) const;

  private:
    double time_ = 0;  // [s]
    bool began_ = false;
    double share_ = 0;  // of the press
};

}  // namespace knead
