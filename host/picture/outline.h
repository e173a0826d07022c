// Thin lines in a picture: around chosen objects, along an axis.
#pragma once
#include "cuda/math/box.h"
#include "render/painter.h"

namespace knead {

// Adds a line of square section, `thick` [m] wide.
void add_line(Mesh& mesh, Vec3<double> from, Vec3<double> to, double thick);
// The corners of a box, each with three lines of a fifth of its sides.
Mesh box_corners(const Box3<double>& box, double thick);

// Linear RGB.
inline constexpr Vec3<float> chosen_colour{1, 0.4f, 0.02f}, hovered_colour{0.8f, 0.8f, 0.8f};
HandLook mark_look(Mesh mesh, Vec3<float> colour, float opacity = 1);

}  // namespace knead
