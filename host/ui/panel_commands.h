// Commands that window and headset have in common.
#pragma once
#include "host/document/command.h"

namespace knead {

// Sets all that a command can change of the hands.
SetHands hands_command(const HandSettings& to);

}  // namespace knead
