// Shapes of objects: what is inside, how deep, how much it is.
#pragma once
#include <optional>
#include <string>

#include "cuda/math/box.h"
#include "host/scene/scene.h"

namespace knead {

// Signed depth of x below an object's surface [m], negative outside. Near the surface exact to
// first order; elsewhere its magnitude is a lower bound. Always outside for shape `splats`, for a
// text without letters and for a mesh that is not loaded. Of a strand: in the tube around its path
// with the radius reach_of(), which its box and its extents contain.
double depth(const Object& object, Vec3<double> x);
bool inside(const Object& object, Vec3<double> x);

// The smallest box along the axes that contains an object, rotated, its centre, and the lengths of
// its edges [m]. Of shape `splats` or `mesh`: what is loaded, or nothing.
Box3<double> box_of(const Object& object);
Vec3<double> middle_of(const Object& object);
Vec3<double> extents(const Object& object);
double shape_volume(const Object& object);  // [m^3]

// Sets Object::letters of a text; null if it has none.
void add_letters(Object& object);

// Of a mesh: its longest extent, upright [m]; 0 if that is by its scale and the file is not loaded.
double mesh_extent(const Object& object);

constexpr double largest_extent = 1000;  // [m]

// What is wrong with a shape, by the key of scenes that gives it.
struct ShapeFault {
    std::string key, expected, found;
};
// Of an object with letters. The first fault; empty: valid. Nothing of shape `splats` is checked,
// nor the extent of a mesh that is not loaded.
std::optional<ShapeFault> shape_fault(const Object& object);

}  // namespace knead
