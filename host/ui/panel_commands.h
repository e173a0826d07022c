// Commands that window and headset have in common.
#pragma once
#include "host/document/command.h"
#include "host/live/live_session.h"

namespace knead {

// Sets all that a command can change of the hands.
SetHands hands_command(const HandSettings& to);
// Gravity of the scene as opened, or the Earth's if that is zero [m/s^2].
Vec3<double> usual_gravity(const LiveState& state);

}  // namespace knead
