// What a hand, or the controller in it, does beside shaping: pinches, makes a fist, points, forms a
// ring. Independent of OpenXR calls, OpenGL and the simulation.
#pragma once
#include <optional>

#include "host/hands/hands.h"
#include "xr/headset.h"

namespace knead {

// The circle within thumb and index finger whose tips meet.
struct FingerRing {
    Vec3<double> centre{}, axis{0, 0, 1};  // [m]; unit, of either sign
    double diameter = 0;                   // between the fingers' skins [m]
};

// In the frame of the hand that it was read from.
struct HandAct {
    bool tracked = false;
    bool pinches = false, fist = false;  // never both
    bool by_controller = false;
    bool lower = false, upper = false;  // buttons of the controller
    // Between the tips of thumb and index finger, turned as the palm.
    Joint<double> at{{1, 0, 0, 0}, {0, 0, 0}};
    Vec3<double> ray{0, 0, -1};      // from there, unit
    std::optional<FingerRing> ring;  // of a tracked hand
};

// Distance of the tips of thumb and index finger [m]; none if one of them is not tracked.
std::optional<double> tips_apart(const Hand& hand);
std::optional<FingerRing> finger_ring(const Hand& hand);

// Reads one side, frame by frame.
class HandReader {
  public:
    static constexpr double closes = 0.022, opens = 0.034;  // a pinch: tips_apart() [m]
    static constexpr float pulls = 0.7f, lets = 0.4f;       // the same by a trigger, or a grip
    // A tracked hand that is closed farther, its index finger as well, makes a fist (closure()).
    // Others than the index finger are often closed in a pinch.
    static constexpr float fist = 0.7f, no_fist = 0.45f, fist_index = 0.55f, no_fist_index = 0.35f;

    // `found`, its aim included, and `head` in one frame. Without an aim of the runtime the hand
    // points away from its shoulder.
    HandAct frame(Side side, const TrackedHand& found, const Joint<float>& head);

  private:
    bool pinches_ = false, fist_ = false;
};

}  // namespace knead
