// Draws lines of text into pictures.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "host/files/image.h"

namespace knead {

// The letters of a line as pen strokes. Unit: a sixth of a capital's height; x from the left of the
// first letter, y downwards from the top of the capitals. Printable ASCII; other characters are
// boxes.
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

// Writes a line in white with a dark outline, legible on any background. x, y: its centre [pixels
// from the left and from the top]; `height`: of capitals [pixels]. Clipped to the picture.
void write_text(Image& image, const std::string& text, double x, double y, double height);

}  // namespace knead
