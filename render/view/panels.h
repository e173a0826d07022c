// The panels, drawn by Dear ImGui. Precondition: within ImGui::NewFrame() and Render().
#pragma once
#include <functional>

#include "render/view/panel_model.h"

namespace knead {

void style_panels();
float panels_across();  // width from the left edge [pixels]
// The name of an OpenGL texture with the picture.
using PictureTexture = std::function<unsigned(const std::shared_ptr<const Image>&)>;
PanelRequests build_panels(PanelModel& model, const PictureTexture& texture);

}  // namespace knead
