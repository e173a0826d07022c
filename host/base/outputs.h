// Where results go: a folder that is checked before the work starts, and files that appear whole.
#pragma once
#include <string>
#include <vector>

namespace knead {

// Makes the folder, and checks that it can be written to and that none of `names` (files or folders
// in it) is there yet, unless `overwrite`. Throws OutputError. `overwrite` removes nothing.
void prepare_folder(const std::string& folder, const std::vector<std::string>& names,
                    bool overwrite);
// The same for one file.
void prepare_file(const std::string& file, bool overwrite);
// Written beside its place and renamed: the old file or the new one, never neither. Throws
// OutputError.
void write_whole(const std::string& file, const std::string& bytes);

}  // namespace knead
