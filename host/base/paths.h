// What a path says by its ending, and where the files lie that come with the program.
#pragma once
#include <string>
#include <vector>

namespace knead {

// The path's ending in lower case, with its point: ".glb" of "a/Ball.GLB"; "" if it has none.
std::string ending(const std::string& path);

// Whether it names the standard input or output: "-", or "-.obj", which says what comes through it.
// A file of such a name is "./-.obj".
bool is_standard(const std::string& path);

// A file or folder that comes with the program, e.g. "profiling" or "scenes/squeeze.json": beside
// the installed program (share/knead), else in the tree that it was built in, else here. "" if it
// is in none of them. What lies below the working directory is named from there.
std::string shipped(const std::string& name);
// A scene or recording by the name that its user typed: where there is no such file, that of the
// scenes that come with the program, e.g. "squeeze.json", "scenes/squeeze.json" or "squeeze".
std::string file_or_shipped(const std::string& name);

// The names of those scenes, "squeeze" for one, in their order.
std::vector<std::string> shipped_scenes();

}  // namespace knead
