// Sanitises a .glb before tinygltf parses it.
#pragma once
#include <string>

#include "host/files/gltf.h"

namespace knead {

// Returns the file with a document reduced to the keys read here, with checked types, and with
// chunks inside the file. Throws InputError.
std::string guarded_glb(std::string bytes, const std::string& path, GltfSkins skins);

// Throws InputError with path, place, expected and found.
[[noreturn]] void refuse_gltf(const std::string& path, const std::string& where,
                              const std::string& expected, const std::string& found);

}  // namespace knead
