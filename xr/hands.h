// The 26 joints of each hand, as the runtime tracks them.
#pragma once
#include "xr/headset.h"
#include "xr/instance.h"

namespace knead::xr {

class HandTrackers {
  public:
    // Without hand tracking, or where the runtime refuses, no hand is ever tracked.
    HandTrackers(Instance& instance, XrSession session);
    ~HandTrackers();
    HandTrackers(const HandTrackers&) = delete;

    // Where the hand is at `time` in `space`. A hand whose wrist is not valid is not tracked;
    // joints that are not, though the hand is, are marked. No velocities are asked for: filters
    // form their own, so a runtime without any is as good.
    TrackedHand locate(Side side, XrSpace space, XrTime time);

  private:
    Instance& instance;
    XrHandTrackerEXT tracker[side_count] = {XR_NULL_HANDLE, XR_NULL_HANDLE};
    bool sources_told[side_count] = {false, false};
};

// What the runtime answered, as the project's hand.
Hand hand_of(const XrHandJointLocationsEXT& found, Side side);
Joint<float> joint_of(const XrPosef& pose);

}  // namespace knead::xr
