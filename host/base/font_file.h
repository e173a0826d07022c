// The font of panels, of captions and of clay in the shape of a text.
#pragma once
#include <string>

namespace knead {

// A TrueType font of the system, with more than ASCII and Latin-1; "": there is none.
std::string font_file();

}  // namespace knead
