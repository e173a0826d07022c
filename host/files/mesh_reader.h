// Reads triangle meshes from files: .ply, .obj, .stl, and .glb with an embedded buffer.
#pragma once
#include <string>
#include <vector>

#include "host/files/ply.h"
#include "host/surface/mesh.h"

namespace knead {

// Polygons are split into fans; normals are recomputed. GLB: one mesh per primitive, with the
// category of the mesh's `extras`, else N for a mesh named "category N", else 0. Throws InputError
// with path and place unless vertices are finite and indices valid.
std::vector<Mesh> read_mesh(const std::string& path);
Mesh to_mesh(const PlyFile& ply, const std::string& path);
Mesh parse_obj(const std::string& text, const std::string& path);
std::vector<Mesh> parse_glb(const std::string& bytes, const std::string& path);

// Throws InputError unless the mesh has triangles, finite vertices and valid indices; computes
// area-weighted normals.
void finish_mesh(Mesh& mesh, const std::string& path);

}  // namespace knead
