// STL: plain triangles, as used by 3D printing and CAD. STL has no unit; files are read as metres.
#pragma once
#include <string>
#include <vector>

#include "host/files/mesh_reader.h"

namespace knead {

// Binary, if its size says so, or text, whose words may have any case; several solids of a text
// become one mesh. Coincident corners become one vertex. Throws InputError with path and byte or
// line.
FileMesh parse_stl(const std::string& bytes, const std::string& path);

// Binary, without colours and categories. `unit`: of the vertices, for the header. Throws
// OutputError for more than 2^32 triangles, the limit of the format; `path` is used in messages
// only.
std::string stl_bytes(const std::vector<const Mesh*>& meshes, const std::string& path,
                      const std::string& unit = "metres");

}  // namespace knead
