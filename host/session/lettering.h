// Lines of text in pictures.
#pragma once
#include <string>

#include "host/files/image.h"

namespace knead {

// Writes a line in white with a dark edge, so that it is read on any ground. Its middle is at x, y
// [pixels from the left and from the top]; capitals are `height` pixels high. What lies outside of
// the picture is cut off. Printable ASCII; another character is a box.
void write_text(Image& image, const std::string& text, double x, double y, double height);

}  // namespace knead
