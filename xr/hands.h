// Hand tracking: the 26 joints of each hand (XR_EXT_hand_tracking).
#pragma once
#include "xr/headset.h"
#include "xr/instance.h"

namespace knead::xr {

class HandTrackers {
  public:
    // If hand tracking is unsupported or creating a tracker fails, no hand is tracked. Throws
    // XrFailure only if session or instance are lost.
    HandTrackers(Instance& instance, XrSession session);
    ~HandTrackers();
    HandTrackers(const HandTrackers&) = delete;

    // Joints at `time` in `space`. A hand with an invalid wrist is not tracked; other invalid
    // joints are marked in Hand::valid. Velocities are not queried: the filters compute their own,
    // so runtimes without them work as well.
    TrackedHand locate(Side side, XrSpace space, XrTime time);

  private:
    Instance& instance;
    XrHandTrackerEXT tracker[side_count] = {XR_NULL_HANDLE, XR_NULL_HANDLE};
    bool sources_told[side_count] = {false, false};
};

// Converts the runtime's joint locations.
Hand hand_of(const XrHandJointLocationsEXT& found, Side side);
Joint<float> joint_of(const XrPosef& pose);

}  // namespace knead::xr
