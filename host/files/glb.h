// What every binary glTF 2.0 (.glb) that is written is made of.
#pragma once
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace knead {

// What a file begins with, and the types of its two chunks.
constexpr std::uint32_t glb_magic = 0x46546c67, glb_json = 0x4e4f534a, glb_binary = 0x004e4942;

// glTF's numbers for what the buffer holds.
enum : int {
    gltf_byte = 5121,
    gltf_index = 5125,
    gltf_float = 5126,
    gltf_vertices = 34962,
    gltf_indices = 34963
};

// A document and its one buffer.
struct Glb {
    nlohmann::json gltf;
    std::string binary;  // of numbers of 4 bytes, or four of one: aligned
};

// One view and one accessor of `count` times `type` ("VEC3") into the buffer; returns the
// accessor's index.
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

// The file's bytes; throws OutputError with `path` and `otherwise` for more than its 4 GiB.
std::string glb_bytes(Glb glb, const std::string& path, const std::string& otherwise);

}  // namespace knead
