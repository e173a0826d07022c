// An empty table: the scene of sessions that begin without a file.
#pragma once
#include <string>

namespace knead {

// Stands for the scene where a path is expected. A file of this name is "./new".
inline constexpr const char* new_scene_name = "new";
// Its text, as of a file.
std::string new_scene();
// The text of the scene at `path`, which may be new_scene_name. Throws InputError.
std::string scene_text(const std::string& path);

}  // namespace knead
