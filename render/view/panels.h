// The panels, by Dear ImGui. A frame of it must have begun.
#pragma once
#include "render/view/panel_model.h"

namespace knead {

void style_panels();
float panels_across();  // from the left edge [pixels]
PanelRequests build_panels(PanelModel& model);

}  // namespace knead
