// STL: triangles and nothing else, as printers of things and CAD programs exchange them. A file has
// no unit; metres are written, and taken for what is read.
#pragma once
#include <string>
#include <vector>

#include "host/surface/mesh.h"

namespace knead {

// Binary or text; several solids of a text become one mesh. Corners at the same place become one
// vertex. Throws InputError with path and byte or line.
Mesh parse_stl(const std::string& bytes, const std::string& path);

// Binary; the meshes' colours and categories have no place in it. Throws OutputError for more than
// its 2^32 triangles; `path` is for messages.
std::string stl_bytes(const std::vector<const Mesh*>& meshes, const std::string& path);

}  // namespace knead
