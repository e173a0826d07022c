// The font of panels, of captions and of clay in the shape of a text.
#pragma once
#include <string>

namespace knead {

// A TrueType font of the system, with more than ASCII and Latin-1; "": there is none.
std::string font_file();

// The bytes of a TrueType font whose tables lie in its file; "": the file is no such font. Readers
// of fonts that do not look where a table ends read past its bytes otherwise.
std::string font_bytes(const std::string& path);

}  // namespace knead
