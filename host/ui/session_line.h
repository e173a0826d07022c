// What panels of window and headset say of a session: whether it is saved, and what can be
// recovered.
#pragma once
#include <string>

#include "host/live/live_session.h"

namespace knead {

// One line: trouble with the log, "saved as X", "unsaved", or "" if there is nothing to save.
std::string session_line(const LiveState& state);
// Why the command is not available in this state; "": it is.
std::string why_not(const Command& command, const LiveState& state);
// Where to save: as the last time, else the scene's name in the working directory, with a number
// if there is such a file.
Save save_command(const LiveState& state);
std::string duration_text(double seconds);
// For a headset, at its start: that there are so many sessions to recover. "": there are none.
std::string recovery_line(std::size_t count);

}  // namespace knead
