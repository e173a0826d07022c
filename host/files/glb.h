// Common parts of all binary glTF 2.0 files (.glb) that are written.
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace knead {

// Magic number of a file, and the types of its two chunks.
constexpr std::uint32_t glb_magic = 0x46546c67, glb_json = 0x4e4f534a, glb_binary = 0x004e4942;

// glTF enumerants of component types and buffer targets.
enum : int {
    gltf_byte = 5121,
    gltf_index = 5125,
    gltf_float = 5126,
    gltf_vertices = 34962,
    gltf_indices = 34963
};

// A glTF document and its single buffer.
struct Glb {
    nlohmann::json gltf;
    std::string binary;  // aligned: components of 4 bytes, or four of one byte
};

// Appends `values` to the buffer, with a view and an accessor of `count` elements of `type`
// ("VEC3"); returns the accessor's index.
template <class T>
int add_accessor(Glb& glb, const std::vector<T>& values, int component, const char* type,
                 std::size_t count, int target)
{
    const std::size_t size = values.size() * sizeof(T);
    glb.gltf["bufferViews"].push_back({{"buffer", 0},
                                       {"byteOffset", glb.binary.size()},
                                       {"byteLength", size},
                                       {"target", target}});
    glb.gltf["accessors"].push_back({{"bufferView", glb.gltf["bufferViews"].size() - 1},
                                     {"componentType", component},
                                     {"count", count},
                                     {"type", type}});
    glb.binary.append(reinterpret_cast<const char*>(values.data()), size);
    return int(glb.gltf["accessors"].size()) - 1;
}

// Returns the bytes of the file. Throws OutputError with `path` and `otherwise` for more than the 4
// GiB of the format.
std::string glb_bytes(Glb glb, const std::string& path, const std::string& otherwise);

}  // namespace knead
