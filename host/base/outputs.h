// Where results go: a folder that is checked before the work starts, and files that appear whole.
#pragma once
#include <functional>
#include <string>
#include <vector>

#include "host/base/folder_lock.h"

namespace knead {

// Makes the folder, locks it unless the lock is given, and checks that it can be written to and
// that none of `names` (files in it, or with a '/' at the end folders) is there yet, unless
// `overwrite`: then that what is there is of its kind. Throws OutputError. `overwrite` removes
// nothing. Hold the lock until the last file is written.
[[nodiscard]] FolderLock prepare_folder(const std::string& folder,
                                        const std::vector<std::string>& names, bool overwrite,
                                        FolderLock lock = {});
// The same for one file.
void prepare_file(const std::string& file, bool overwrite);

// What a killed program left in a folder: half a file, where no process has its number, or a lock
// that no process holds.
struct Leftover {
    std::string path, of;  // of: the name of the file that it was to be, or lock_name
};
std::vector<Leftover> leftovers(const std::string& folder);  // by path; none where there is none
// Removes those for which ours(of) holds.
void remove_partials(const std::string& folder,
                     const std::function<bool(const std::string&)>& ours);
// Removes those of the files in the folder that are there, in this order. Throws OutputError.
void remove_files(const std::string& folder, const std::vector<std::string>& names);

// A file under making, beside its place and with the same ending, so that a program of its own may
// write it, too; nothing that is there has its name. Its name is the file's with a mark, cut where
// the file system takes no longer one. It goes with the object, unless it was put in
// place. Where `file` is a symbolic link, the link stays and what it names is replaced.
class PartialFile {
  public:
    // Makes it, empty. All throw OutputError with the file's path and the reason.
    explicit PartialFile(const std::string& file);
    ~PartialFile();
    PartialFile(const PartialFile&) = delete;
    PartialFile& operator=(const PartialFile&) = delete;

    const std::string& path() const { return partial; }
    void write(const std::string& bytes);  // at its end
    // The same; `stop` is asked every few MiB, each of which is then sent to the disk. False: it
    // was given up, and what there is of the file is of no use.
    bool write_unless(const std::function<bool()>& stop, const std::string& bytes);
    // Flushes it to the disk and renames it: the old file or the new one, never neither, never
    // half. Once.
    void put_in_place();

  private:
    std::string file, place, partial;  // place: `file` with its links followed
    int made = -1;                     // its descriptor
};

// The one way a file is written; to the standard output where is_standard() (paths.h). Throws
// OutputError; the old file, if there is one, is then left. So it is where a signal comes meanwhile
// that is not watched (interrupt.h), and ends the program.
void write_whole(const std::string& file, const std::string& bytes);
// The same, but where `stop`, asked on the way, says so: false, and the old file is left.
bool write_whole_unless(const std::function<bool()>& stop, const std::string& file,
                        const std::string& bytes);

}  // namespace knead
