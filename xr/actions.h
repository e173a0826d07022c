// Controller input by OpenXR actions: grip pose, trigger, grasp, vibration.
#pragma once
#include <optional>

#include "xr/headset.h"
#include "xr/instance.h"

namespace knead::xr {

// State of one side's controller, or of the hand interaction profile.
struct HeldButtons {
    bool active = false;  // the grip pose is valid
    Joint<float> grip{};
    float trigger = 0, grasp = 0;  // 0 to 1
    bool lower = false, upper = false;
    std::optional<Joint<float>> aim;  // none: the profile has no such pose, or it is not valid
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
    std::optional<Joint<float>> pose(XrAction of, const XrSpace (&spaces)[side_count], Side side,
                                     XrSpace base, XrTime time);

    Instance& instance;
    XrSession session;
    XrPath hand[side_count];
    XrActionSet set = XR_NULL_HANDLE;
    XrAction grip, aim, trigger, grasp, lower, upper, buzz;
    XrSpace grips[side_count] = {XR_NULL_HANDLE, XR_NULL_HANDLE},
            aims[side_count] = {XR_NULL_HANDLE, XR_NULL_HANDLE};
};

}  // namespace knead::xr
