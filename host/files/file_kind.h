// What a file is, by its ending and, for PLY and JSON, its content.
#pragma once
#include <string>

namespace knead {

enum class FileKind { scene, report, recording, mesh, particles };
// Throws InputError where the file cannot be read or is none of these.
FileKind file_kind(const std::string& path);

}  // namespace knead
