// Writes meshes to files.
#pragma once
#include <string>
#include <vector>

#include "host/surface/mesh.h"

namespace knead {

// What a file says of its meshes.
struct MeshLabels {
    // One per mesh, UTF-8; empty: "category N". In OBJ with '_' in place of white space; a GLB has
    // the category in `extras` of a mesh with another name.
    std::vector<std::string> names;
    std::string unit = "metres";  // of the vertices, for 3MF and the comments of OBJ, PLY and STL
};

// Writes the format given by the extension: .glb, .obj, .ply, .stl, .3mf. Throws OutputError with
// path and reason.
void write_mesh(const std::string& path, const std::vector<Mesh>& meshes,
                const MeshLabels& labels = {});

}  // namespace knead
