// Shader programs from pieces of GLSL, and their common vertex layout.
#pragma once
#include <initializer_list>
#include <string>

#include "render/gl.h"

namespace knead {

// The pieces of each shader are concatenated. Throws std::runtime_error with `name` and the
// compiler's message.
Program program(std::initializer_list<std::string> vertex,
                std::initializer_list<std::string> fragment, const std::string& name);

// Vertex array of PaintVertex (render/geometry.h) in `vertices`, indexed by `triangles`: place,
// normal, colour and skin at locations 0, 1, 2.
VertexArray paint_layout(GLuint vertices, GLuint triangles);

// Depth texture array of `layers` lamps with comparison. Outside the map nothing is in shadow.
Texture shadow_maps(int side, int layers);

}  // namespace knead
