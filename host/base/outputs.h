// Output files: the folder is checked before the work starts, and files are written atomically.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/base/folder_lock.h"

namespace knead {

// Creates the folder, locks it unless a lock is passed, and checks that it is writable and that
// none of `names` (files in it, or folders if they end in '/') exists. With `overwrite`, existing
// ones must be of the same kind; they are not removed. Throws OutputError. Keep the lock until the
// last file is written.
[[nodiscard]] FolderLock prepare_folder(const std::string& folder,
                                        const std::vector<std::string>& names, bool overwrite,
                                        FolderLock lock = {});
// The same for one file.
void prepare_file(const std::string& file, bool overwrite);

// Remains of a killed program in a folder: a partial file whose process does not exist, or a lock
// that no process holds.
struct Leftover {
    std::string path, of;  // of: name of the intended file, or lock_name
};
std::vector<Leftover> leftovers(const std::string& folder);  // sorted by path; empty if there are
                                                             // none
// Removes those with ours(of).
void remove_partials(const std::string& folder,
                     const std::function<bool(const std::string&)>& ours);
// Removes the existing ones of these files, in this order. Throws OutputError.
void remove_files(const std::string& folder, const std::vector<std::string>& names);

// A temporary file in the folder of its target, with the same ending, so that external programs can
// write it. Its name is unique: the target's plus a mark, shortened to the limit of the file
// system. Removed by the destructor unless put in place. If `file` is a symbolic link, its target
// is replaced.
class PartialFile {
  public:
    // Creates it, empty. All members throw OutputError with the file's path and the reason.
    explicit PartialFile(const std::string& file);
    ~PartialFile();
    PartialFile(const PartialFile&) = delete;
    PartialFile& operator=(const PartialFile&) = delete;

    const std::string& path() const { return partial; }
    void write(const std::string& bytes);  // appends
    // Appends bytes [at, at + count) of an open file; shares its blocks where the file system can.
    // `source`: its path. Throws InputError if it cannot be read or ends before.
    void append(int from, const std::string& source, std::uint64_t at, std::uint64_t count);
    // The same as write(), but calls `stop` every few MiB and flushes each part to disk. Returns
    // false if stopped; the file is then incomplete.
    bool write_unless(const std::function<bool()>& stop, const std::string& bytes);
    // Flushes to disk and renames atomically: readers see the old file or the new one. Call once.
    void put_in_place();

  private:
    std::string file, place, partial;  // place: `file` with its symbolic links resolved
    int made = -1;                     // descriptor
};

// Writes a file atomically, or to standard output if is_standard() (paths.h); used for all files.
// Throws OutputError. Strong guarantee: on errors, and on signals that are not watched
// (interrupt.h), an existing file is unchanged.
void write_whole(const std::string& file, const std::string& bytes);
// The same of a file that is made part by part: make(add) calls add(bytes) for each, in order, and
// is left by an exception of its own kind where writing ends early.
using AddBytes = std::function<void(const std::string& bytes)>;
void write_in_parts(const std::string& file, const std::function<void(const AddBytes& add)>& make);
// As write_whole(), but calls `stop` meanwhile. Returns false if stopped; an existing file is
// unchanged.
bool write_whole_unless(const std::function<bool()>& stop, const std::string& file,
                        const std::string& bytes);

}  // namespace knead
