// The scenes that a session can change to.
#pragma once
#include <string>
#include <vector>

namespace knead {

// A name of the file that is the same for all paths to it.
std::string path_key(const std::string& path);
// Scenes (.json) in the folder of `path`, by their paths, sorted; `path` is among them.
std::vector<std::string> scenes_beside(const std::string& path);

}  // namespace knead
