// List of the scenes that a session can load.
#pragma once
#include <string>
#include <vector>

namespace knead {

// Canonical name of a file, equal for all paths to it.
std::string path_key(const std::string& path);
// Paths of the scenes (.json) in the folder of `path`, sorted; includes `path`.
std::vector<std::string> scenes_beside(const std::string& path);

}  // namespace knead
