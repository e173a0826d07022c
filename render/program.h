// Shader programs from pieces of GLSL, and the one list of vertices that all of them read.
#pragma once
#include <initializer_list>
#include <string>

#include "render/gl.h"

namespace knead {

// The pieces of each shader are one text. Throws std::runtime_error with what the compiler says;
// `name` is for that.
Program program(std::initializer_list<std::string> vertex,
                std::initializer_list<std::string> fragment, const std::string& name);

// PaintVertex (render/geometry.h) from `vertices`, by `triangles`: place, normal, colour and skin
// at locations 0, 1, 2.
VertexArray paint_layout(GLuint vertices, GLuint triangles);

// Depths seen by `layers` lamps, to be compared with. Outside the map nothing stands in the way.
Texture shadow_maps(int side, int layers);

}  // namespace knead
