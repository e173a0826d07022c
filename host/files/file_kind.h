// File type detection: by content where it identifies the type (PLY, SPZ, JSON), otherwise by
// extension.
#pragma once
#include <string>

namespace knead {

enum class FileKind { scene, report, recording, mesh, particles, splats, session };
// Replaces "-", standard input, by a name with the format: "-.glb", from `format` (".glb" or "glb")
// or the first bytes. Returns any other path unchanged. Throws InputError if neither gives the
// format.
std::string with_form(const std::string& path, const std::string& format = "");

// Throws InputError if the file cannot be read or has none of these types.
FileKind file_kind(const std::string& path);

}  // namespace knead
