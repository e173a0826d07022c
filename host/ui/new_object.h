// Objects that the panel adds.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "host/live/live_session.h"

namespace knead {

// Shapes of the panel's list, in its order. An object is named after its shape.
struct NewShape {
    ShapeKind shape;
    const char* name;
};
inline constexpr std::array<NewShape, 9> new_shapes{{{ShapeKind::sphere, "ball"},
                                                     {ShapeKind::ellipsoid, "ellipsoid"},
                                                     {ShapeKind::box, "box"},
                                                     {ShapeKind::rounded_box, "rounded box"},
                                                     {ShapeKind::cylinder, "cylinder"},
                                                     {ShapeKind::cone, "cone"},
                                                     {ShapeKind::capsule, "capsule"},
                                                     {ShapeKind::torus, "torus"},
                                                     {ShapeKind::text, "text"}}};
inline constexpr const char* usual_text = "knead";

// "BASE", or the first of "BASE 2", "BASE 3", ... that no object has.
std::string free_name(const Document& document, const std::string& base);
int free_category(const Document& document);  // one that has no splats

// A new object about a fifth as wide as the shortest side between the walls. It is placed above the
// clay at the middle, or at the nearest of 5 x 5 places with enough room; if none has, at the
// middle below the upper wall. `recent`: objects that the surface may lack; their boxes come from
// the document. `text`: for the shape `text`. Precondition: there is a document.
SceneObject new_object(const LiveState& state, const std::vector<ObjectId>& recent,
                       const NewShape& shape, const MaterialSpec& material,
                       const std::string& text);

// An object of a mesh, two fifths as long as the shortest side between the walls, at the place of a
// new object. Up is z in .stl and .3mf files, in others y. The file is not read. Precondition:
// there is a document.
SceneObject new_mesh(const LiveState& state, const std::string& file);

}  // namespace knead
