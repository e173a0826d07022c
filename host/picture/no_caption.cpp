// For builds without Dear ImGui.
#ifndef KNEAD_HAS_PANEL
#include "host/picture/caption.h"

namespace knead {

bool draws_text() { return false; }

void write_text(Image&, const std::string&, double, double, double) {}

}  // namespace knead
#endif
