// Reads triangle meshes from files: .ply, .obj, .stl, .3mf, and .glb with an embedded buffer.
#pragma once
#include <string>
#include <vector>

#include "cuda/math/box.h"
#include "host/files/ply.h"
#include "host/surface/mesh.h"

namespace knead {

// A mesh as its file has it, in double: coordinates of maps, millions of metres from their origin,
// would lose their shape in float.
struct FileMesh {
    std::string name;  // "": none
    int category = 0;
    std::vector<Vec3<double>> vertices;  // in units of the file; of a 3MF, which has one: [m]
    std::vector<Int3> triangles;         // vertex indices
    std::vector<Vec3<float>> colours;    // linear RGB, one per vertex; empty: none
};
struct MeshFile {
    std::vector<FileMesh> meshes;    // at least one; each has triangles
    std::vector<std::string> notes;  // what was left out, without the path
    double unit = 0;                 // that the file names [m]; 0: none
};

// Polygons are split into fans, triangle strips into triangles. GLB: one mesh per primitive, with
// the category of the mesh's `extras`, else N for a mesh named "category N", else 0. Throws
// InputError with path and place unless vertices are finite and indices valid.
MeshFile read_mesh_file(const std::string& path);
FileMesh to_mesh(const PlyFile& ply, const std::string& path);
MeshFile parse_obj(const std::string& text, const std::string& path);
MeshFile parse_glb(const std::string& bytes, const std::string& path);

// The same in float, with area-weighted normals. `origin`: subtracted first.
std::vector<Mesh> float_meshes(const MeshFile& file, const std::string& path,
                               Vec3<double> origin = {});
std::vector<Mesh> read_mesh(const std::string& path);

Box3<double> box_of(const std::vector<FileMesh>& meshes);
double volume(const FileMesh& mesh);  // enclosed, positive for outward triangles

// Throws InputError unless the mesh has triangles, finite vertices and valid indices.
void check_mesh(const FileMesh& mesh, const std::string& path);
// The same, and computes area-weighted normals.
void finish_mesh(Mesh& mesh, const std::string& path);

// Linear RGB from sRGB, 0 to 1.  IEC 61966-2-1
Vec3<float> linear_colour(Vec3<double> srgb);

}  // namespace knead
