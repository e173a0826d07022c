// The shape of a text: its outline as distances.
#pragma once
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/scene/glyphs.h"

namespace knead {

// Lengths in heights of a capital. The origin is the centre of the outline's box.
class Letters {
  public:
    explicit Letters(const std::vector<std::vector<Point2>>& contours);

    // Signed depth, negative outside. Exact within a capital's height of the outline; elsewhere its
    // magnitude is a lower bound.
    double depth(Point2 at) const;
    double area() const { return area_; }
    // Lowest and highest of dot(p, along) over the points p of the outline.
    std::pair<double, double> reach(Point2 along) const;
    double width() const { return width_; }
    double height() const { return height_; }

  private:
    // A part of the outline; the inside is on its left. The normals at its ends point outwards,
    // and are those of both edges that meet there.
    struct Edge {
        Point2 a, b, along, normal_a, normal_b;  // along: of length 1
        double length;
    };
    // A square: four smaller ones, or the edges that may be the nearest of a point in it, or a
    // depth at its centre, if it is far from the outline.
    struct Square {
        int first = -1;  // of the four smaller ones; -1: none
        int begin = 0, end = 0;
        double depth = 0;
    };
    struct Nearest {
        double squared, depth;
    };
    static Nearest nearest(const Edge& edge, Point2 at);
    void divide(int square, Point2 centre, double half, const std::vector<int>& near);

    std::vector<Edge> edges_;
    std::vector<Square> squares_;
    std::vector<int> near_;
    double area_ = 0, width_ = 0, height_ = 0, half_ = 0;  // half_: of the largest square
};

// From the font of the system. Equal texts share one object until the cache of 64 texts is full and
// cleared. On failure `letters` is null and `why` says what was found.
struct MadeLetters {
    std::shared_ptr<const Letters> letters;
    std::string why;
};
MadeLetters letters_of(const std::string& text);

}  // namespace knead
