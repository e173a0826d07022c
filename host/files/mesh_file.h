// Meshes written to files.
#pragma once
#include <string>
#include <vector>

#include "host/surface/mesh.h"

namespace knead {

// By the ending of the path: .glb, .obj, .ply, .stl. Throws OutputError with path and reason.
void write_mesh(const std::string& path, const std::vector<Mesh>& meshes);

}  // namespace knead
