// File name endings, standard streams, and the files installed with the program.
#pragma once
#include <string>
#include <vector>

namespace knead {

// The path's ending in lower case, with the dot: ".glb" of "a/Ball.GLB"; "" if it has none.
std::string ending(const std::string& path);

// True for standard input or output: "-", or "-.obj", whose ending names the format. A file of that
// name is "./-.obj".
bool is_standard(const std::string& path);

// Path of a file or folder installed with the program, e.g. "profiling" or "scenes/squeeze.json".
// Searches the installation (share/knead), the build's source tree, and the working directory; ""
// if not found. Paths below the working directory are relative to it.
std::string shipped(const std::string& name);
// Resolves a scene or recording by the name that a user typed: an existing file, else one of the
// installed scenes, e.g. "squeeze.json", "scenes/squeeze.json" or "squeeze".
std::string file_or_shipped(const std::string& name);

// Names of the installed scenes, sorted, e.g. "squeeze".
std::vector<std::string> shipped_scenes();

}  // namespace knead
