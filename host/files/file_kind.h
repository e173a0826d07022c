// What a file is, by its content where that says it (PLY, SPZ, JSON), else by its ending.
#pragma once
#include <string>

namespace knead {

enum class FileKind { scene, report, recording, mesh, particles, splats };
// Throws InputError where the file cannot be read or is none of these.
FileKind file_kind(const std::string& path);

}  // namespace knead
