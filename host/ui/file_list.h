// Contents of a folder as a file chooser shows them.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace knead {

struct FileEntry {
    std::string name;
    bool is_folder = false;
    std::uint64_t size = 0;  // [bytes]; of a folder: 0
    double modified = 0;     // [s since 1970, UTC]
};

struct FileList {
    struct Parent {
        std::string name, path;
    };
    std::string folder;              // absolute
    std::vector<Parent> parents;     // from the root to the folder itself
    std::vector<FileEntry> entries;  // folders first, then by name without regard to case
    std::string note;                // that entries were left out; "": none were
    std::string error;               // why the folder cannot be read, or not to its end; ""
};

constexpr std::size_t most_file_entries = 10000;

// Lists folders and regular files, links followed, without hidden ones. `folder`: "" is the working
// directory. `endings`: of the files that are listed, in lower case with the dot; empty: all. Of
// more than `most` entries some are left out. Does not throw for what the file system reports.
FileList list_files(const std::string& folder, const std::vector<std::string>& endings = {},
                    std::size_t most = most_file_entries);

}  // namespace knead
