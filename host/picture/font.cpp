#include "host/picture/font.h"

#include <imgui.h>

namespace knead {

float capital_of(const ImFont& font)
{
    const ImFontGlyph* const glyph = font.FindGlyph('H');
    return glyph ? glyph->Y1 - glyph->Y0 : 0.7f * font.FontSize;
}

}  // namespace knead
