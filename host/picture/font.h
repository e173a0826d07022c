// Sizes of Dear ImGui's fonts. Only part of builds with Dear ImGui. The file of a font: font_file()
// in host/base, because Dear ImGui's own font, of 13 pixels, has ASCII and Latin-1 alone.
#pragma once

struct ImFont;

namespace knead {

// Height of capitals [pixels].
float capital_of(const ImFont& font);

}  // namespace knead
