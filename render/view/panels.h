// The panels, drawn by Dear ImGui. Precondition: within ImGui::NewFrame() and Render().
#pragma once
#include "render/view/panel_model.h"

namespace knead {

void style_panels();
float panels_across();  // width from the left edge [pixels]
PanelRequests build_panels(PanelModel& model);

}  // namespace knead
