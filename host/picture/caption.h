// Draws lines of text into pictures.
#pragma once
#include <string>

#include "host/files/image.h"

namespace knead {

// Whether this build draws text: with Dear ImGui.
bool draws_text();

// Writes a line of UTF-8 in white with a dark outline, legible on any background, in the font of
// font_file(); bytes and characters that it lacks have its sign for such. x, y: its centre [pixels
// from the left and from the top], in height that of its capitals; `height`: of capitals [pixels].
// Clipped to the picture. Not while another thread uses Dear ImGui.
void write_text(Image& image, const std::string& text, double x, double y, double height);

}  // namespace knead
