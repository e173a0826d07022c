// Common parts of binary glTF 2.0 files (.glb): their chunks, and documents that are written.
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

// Appends to a document the view and the accessor of `size` bytes at `offset` of the buffer, as
// add_accessor() does; returns the accessor's index.
int describe_accessor(nlohmann::json& gltf, std::size_t offset, std::size_t size, int component,
                      const char* type, std::size_t count, int target);

// Appends `values` to the buffer, with a view and an accessor of `count` elements of `type`
// ("VEC3"); returns the accessor's index.
template <class T>
int add_accessor(Glb& glb, const std::vector<T>& values, int component, const char* type,
                 std::size_t count, int target)
{
    const std::size_t size = values.size() * sizeof(T), offset = glb.binary.size();
    glb.binary.append(reinterpret_cast<const char*>(values.data()), size);
    return describe_accessor(glb.gltf, offset, size, component, type, count, target);
}

// Size of the JSON chunk, which begins at byte 20 of a file of `size` bytes; `head`: those before,
// or all that there are. Throws InputError if the chunk ends outside the file.
std::size_t glb_json_size(const std::string& head, std::size_t size, const std::string& path);
// Size of the binary chunk, whose header of 8 bytes begins at byte `at`. Throws InputError if the
// header is cut or the chunk ends outside the file.
std::size_t glb_binary_size(const std::string& header, std::size_t at, std::size_t size,
                            const std::string& path);

// The bytes of a file with a buffer of this size, up to the buffer. Throws OutputError as
// glb_bytes().
std::string glb_head(nlohmann::json gltf, std::size_t size, const std::string& path,
                     const std::string& otherwise);

// Returns the bytes of the file. Throws OutputError with `path` and `otherwise` for more than the 4
// GiB of the format.
std::string glb_bytes(Glb glb, const std::string& path, const std::string& otherwise);

}  // namespace knead
