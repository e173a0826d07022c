// Controller input by OpenXR actions: grip pose, trigger, grasp, vibration.
#pragma once
#include "xr/headset.h"
#include "xr/instance.h"

namespace knead::xr {

// State of one side's controller, or of the hand interaction profile.
struct HeldButtons {
    bool active = false;  // the grip pose is valid
    Joint<float> grip{};
    float trigger = 0, grasp = 0;  // 0 to 1
};

class Actions {
  public:
    Actions(Instance& instance, XrSession session);
    ~Actions();
    Actions(const Actions&) = delete;

    void sync();
    HeldButtons held(Side side, XrSpace base, XrTime time);
    void vibrate(Side side, float strength);

  private:
    void suggest();
    XrAction action(XrActionType type, const char* name, const char* shown);
    float value(XrAction of, Side side);

    Instance& instance;
    XrSession session;
    XrPath hand[side_count];
    XrActionSet set = XR_NULL_HANDLE;
    XrAction grip, trigger, grasp, buzz;
    XrSpace space[side_count] = {XR_NULL_HANDLE, XR_NULL_HANDLE};
};

}  // namespace knead::xr
