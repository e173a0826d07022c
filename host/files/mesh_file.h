// Writes meshes to files.
#pragma once
#include <string>
#include <vector>

#include "host/surface/mesh.h"

namespace knead {

// Writes the format given by the extension: .glb, .obj, .ply, .stl. Throws OutputError with path
// and reason.
void write_mesh(const std::string& path, const std::vector<Mesh>& meshes);

}  // namespace knead
