// What a file is, by its content where that says it (PLY, SPZ, JSON), else by its ending.
#pragma once
#include <string>

namespace knead {

enum class FileKind { scene, report, recording, mesh, particles, splats };
// What comes through the standard input, as a name that says its format: "-.glb" for "-", as told
// (".glb" or "glb") or else by how it begins; any other path as it is. Throws InputError where
// neither says it.
std::string with_form(const std::string& path, const std::string& told = "");

// Throws InputError where the file cannot be read or is none of these.
FileKind file_kind(const std::string& path);

}  // namespace knead
