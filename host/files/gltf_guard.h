// What of a .glb reaches tinygltf.
#pragma once
#include <string>

#include "host/files/gltf.h"

namespace knead {

// The same file with a document of only what is read here, of the right types, and with chunks that
// lie inside. Throws InputError.
std::string guarded_glb(std::string bytes, const std::string& path, GltfSkins skins);

// Throws InputError with path, place, what was expected and found.
[[noreturn]] void refuse_gltf(const std::string& path, const std::string& where,
                              const std::string& expected, const std::string& found);

}  // namespace knead
