// Outlines of letters, from a font's file. Builds without stb_truetype have none.
#pragma once
#include <string>
#include <vector>

namespace knead {

// In the plane of a text: x along the line, y upwards. In heights of a capital.
struct Point2 {
    double x, y;
    bool operator==(const Point2&) const = default;
};
inline Point2 operator+(Point2 a, Point2 b) { return {a.x + b.x, a.y + b.y}; }
inline Point2 operator-(Point2 a, Point2 b) { return {a.x - b.x, a.y - b.y}; }
inline Point2 operator*(double s, Point2 a) { return {s * a.x, s * a.y}; }
inline double dot(Point2 a, Point2 b) { return a.x * b.x + a.y * b.y; }
inline double cross(Point2 a, Point2 b) { return a.x * b.y - a.y * b.x; }

constexpr int most_letters = 64;  // of a text, with its blanks and ends of lines

// Closed polygons, which may overlap: what has a winding number other than 0 is filled. Curves are
// replaced by chords, off by at most 2e-4. `fault`: why there are none; "": there are some.
struct GlyphOutlines {
    std::vector<std::vector<Point2>> contours;
    std::string fault;
};
// A text in UTF-8; its lines end with "\n" and are centred. With the font's kerning.
GlyphOutlines glyph_outlines(const std::string& text, const std::string& font);

}  // namespace knead
