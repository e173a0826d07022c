// Small picture with flat colours and capital letters, for the panel in the headset.
#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace knead {

struct PanelRect {
    float x = 0, y = 0, width = 0, height = 0;  // from the upper left corner [pixels]
    bool holds(float px, float py) const
    {
        return px >= x && px < x + width && py >= y && py < y + height;
    }
};
struct PanelColour {
    std::uint8_t r, g, b;  // sRGB
};

// Letters are `letter_height` high, and `letter_step` apart.
constexpr int letter_height = 7, letter_step = 6;  // [pixels]

class PanelCanvas {
  public:
    // `fine`: texels per pixel, in each direction.
    PanelCanvas(int width, int height, int fine);
    void fill(const PanelRect& rect, PanelColour colour);
    // Writes capitals (host/picture/lettering.h). x, y: upper left corner [pixels], rounded to a
    // texel. Clipped at the edge.
    void text(float x, float y, const std::string& words, PanelColour colour);
    int width() const { return wide; }  // [texels]
    int height() const { return high; }
    const std::vector<std::uint8_t>& rgba() const { return texels; }  // top row first

  private:
    int texel(float at) const;
    const std::vector<std::uint8_t>& ink_of(char name);

    int fine, wide, high;
    std::vector<std::uint8_t> texels;
    // Cache, per letter: coverage of its texels, 0 to 255, row by row. Computing the distance to
    // strokes takes a hundred times as long as blending.
    std::map<char, std::vector<std::uint8_t>> inks;
};

}  // namespace knead
