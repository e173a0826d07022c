// Sanitises a .glb before tinygltf parses it.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "host/base/json_reader.h"
#include "host/files/gltf.h"

namespace knead {

struct GuardedGlb {
    // The file with a document reduced to the keys read by tinygltf, with checked types, and with
    // chunks inside the file.
    std::string bytes;
    Json document;  // the whole one; its sections in `bytes` are arrays of objects
};
// Throws InputError, also for an extension that is required and not known here.
GuardedGlb guarded_glb(std::string bytes, const std::string& path, GltfSkins skins);

// Throws InputError with path, place, expected and found.
[[noreturn]] void refuse_gltf(const std::string& path, const std::string& where,
                              const std::string& expected, const std::string& found);

}  // namespace knead
