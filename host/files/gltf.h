// Binary glTF 2.0 (.glb), read by tinygltf: triangles with their colours, and skins.
#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "cuda/math/vec.h"

namespace knead {

// A primitive of a mesh at one of its places in the scene: triangles with shared vertices.
struct GltfPart {
    std::string mesh;             // name of the mesh
    std::optional<int> category;  // extras.category of the mesh, 0 to 255
    std::vector<Vec3<double>> vertices;
    std::vector<Int3> triangles;       // vertex indices
    std::vector<Vec3<float>> colours;  // per vertex, linear RGB; empty: none
    // Per vertex, if skins are read and present: four of the skin's joints, and their weights, not
    // normalised.
    std::vector<std::array<int, 4>> joints;
    std::vector<std::array<double, 4>> weights;
};

struct GltfSkin {
    std::vector<std::string> joints;                   // names of their nodes
    std::vector<std::array<double, 16>> inverse_bind;  // one per joint, column-major
};

struct Gltf {
    std::vector<GltfPart> parts;
    std::vector<GltfSkin> skins;
    std::vector<std::string> notes;  // what was left out
};

// `read`: skins, and all primitives as stored. `ignored`: what the default scene shows, in its
// frame: each mesh at each of its nodes and of their instances (EXT_mesh_gpu_instancing); meshes on
// no node are not shown, unless there are no nodes at all. Transforms are multiplied in double;
// those that mirror turn the triangles. A skinned mesh is in the pose that is stored.
enum class GltfSkins { ignored, read };

// Returns finite vertices and triangles with valid indices, or throws InputError with path, place
// (byte, line, JSON pointer or element), expected and found. Checked before any number is read: all
// numbers together take at most 64 times the file's size, counting repeated references, and there
// are at most 65536 primitives. The single buffer must be in the file; accessors must not be
// sparse.
Gltf parse_gltf(const std::string& bytes, const std::string& path, GltfSkins skins);
Gltf read_gltf(const std::string& path, GltfSkins skins);

}  // namespace knead
