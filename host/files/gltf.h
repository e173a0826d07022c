// Binary glTF 2.0 (.glb), read by tinygltf: triangles, and the skins they hang on.
#pragma once
#include <array>
#include <string>
#include <vector>

#include "cuda/math/vec.h"

namespace knead {

// Triangles of a mesh that share their vertices: a primitive.
struct GltfPart {
    std::string mesh;                   // the mesh's name
    std::vector<Vec3<float>> vertices;  // as stored: no node's transform is applied
    std::vector<Int3> triangles;        // vertex indices
    // Per vertex, where skins are asked for and there are any: four of the skin's joints, and how
    // much it hangs on each, in shares of any sum.
    std::vector<std::array<int, 4>> joints;
    std::vector<std::array<double, 4>> weights;
};

struct GltfSkin {
    std::vector<std::string> joints;                   // names of their nodes
    std::vector<std::array<double, 16>> inverse_bind;  // one per joint, column by column
};

struct Gltf {
    std::vector<GltfPart> parts;
    std::vector<GltfSkin> skins;
    std::string transform;  // JSON pointer of the first transform of a node; "": there is none
};

enum class GltfSkins { ignored, read };

// Whatever the file holds, the answer is finite vertices and triangles that name them, or an
// InputError with path, place (byte, line, JSON pointer or element), what was expected and found.
// All numbers together take at most 64 times the file's size, however often the file names them,
// and there are at most 65536 primitives: both are checked before any number is read.
// Its one buffer must lie inside; accessors are plain, not sparse.
Gltf parse_gltf(const std::string& bytes, const std::string& path, GltfSkins skins);
Gltf read_gltf(const std::string& path, GltfSkins skins);

}  // namespace knead
