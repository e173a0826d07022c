// The font of panels and captions. Only part of builds with Dear ImGui.
#pragma once
#include <string>

struct ImFont;

namespace knead {

// A font of the system with more than ASCII and Latin-1, which is all that Dear ImGui's own, of 13
// pixels, has; "": there is none.
std::string font_file();

// Height of capitals [pixels].
float capital_of(const ImFont& font);

}  // namespace knead
