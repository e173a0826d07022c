// For builds without Dear ImGui.
#ifndef KNEAD_HAS_PANEL
#include "host/ui/panel_drawing.h"

namespace knead {

std::unique_ptr<PanelDrawing> PanelDrawing::open(const PanelDrawingOptions&) { return nullptr; }

}  // namespace knead
#endif
