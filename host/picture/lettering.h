// Lines of text in pictures.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/files/image.h"

namespace knead {

// A line's letters as strokes of a pen. The unit is a sixth of a capital's height; x from the left
// of the first letter, y from the top of the capitals down. Printable ASCII; another character is a
// box.
class Lettering {
  public:
    static constexpr double capital = 6, step = 6;  // how high, and from letter to letter

    explicit Lettering(const std::string& text);
    double width() const { return wide; }
    double distance(double x, double y) const;  // to the nearest stroke

  private:
    struct Point {
        double x, y;
    };
    struct Stroke {
        Point from, to;
    };
    void add(const char* glyph, std::size_t size, double left);

    std::vector<Stroke> strokes;
    double wide;
};

// Writes a line in white with a dark edge, so that it is read on any ground. Its middle is at x, y
// [pixels from the left and from the top]; capitals are `height` pixels high. What lies outside of
// the picture is cut off.
void write_text(Image& image, const std::string& text, double x, double y, double height);

}  // namespace knead
