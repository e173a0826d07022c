// Triangle meshes from files: .ply, .obj, .stl, and .glb with its buffer inside.
#pragma once
#include <string>
#include <vector>

#include "host/files/ply.h"
#include "host/surface/mesh.h"

namespace knead {

// Polygons are cut into fans; normals are recomputed. GLB: one mesh per primitive, whose category
// is that of a mesh named "category N", else 0. Throws InputError with path and place for anything
// else than finite vertices and triangles that name them.
std::vector<Mesh> read_mesh(const std::string& path);
Mesh to_mesh(const PlyFile& ply, const std::string& path);
Mesh parse_obj(const std::string& text, const std::string& path);
std::vector<Mesh> parse_glb(const std::string& bytes, const std::string& path);

// Throws InputError unless the mesh has triangles, finite vertices and valid indices; fills its
// normals, weighted by area.
void finish_mesh(Mesh& mesh, const std::string& path);

}  // namespace knead
