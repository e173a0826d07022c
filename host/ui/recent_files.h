// Scenes and sessions that were opened or saved lately, for all windows and headsets of a user.
#pragma once
#include <string>
#include <vector>

namespace knead {

constexpr std::size_t most_recent_files = 12;

// Absolute paths, the newest first, of those that exist. A list that cannot be read is empty.
std::vector<std::string> recent_files();
// Puts the file first. No effect if the list cannot be written, nor for standard input, a working
// log, or a path that is not UTF-8. Of two processes that write at once, one entry may be lost.
void add_recent_file(const std::string& file);

}  // namespace knead
