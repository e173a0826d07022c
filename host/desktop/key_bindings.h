// Keys of the controls, as their table names them.
#pragma once
#include <string>
#include <vector>

#include "host/ui/panel_model.h"
#include "render/view/input.h"

namespace knead {

// "Ctrl+Shift+Z" as a chord. Throws std::invalid_argument for a name that is no key.
Chord chord_of(const std::string& keys);
// The controls whose keys were pressed, as events; of one whose value is a path or a text: with an
// empty one, to be asked for.
std::vector<ControlEvent> pressed_controls(const InputState& input, const PanelModel& model);

}  // namespace knead
