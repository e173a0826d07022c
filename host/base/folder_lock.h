// Exclusive write access to a folder across processes.
#pragma once
#include <string>

namespace knead {

constexpr const char* lock_name = ".knead-lock";

// Locks a folder, or the files in it named by `set`, for one process: flock(2) on a hidden file
// whose name ends in lock_name and which contains the process id. A crash releases the lock but
// leaves the file, which the next lock reuses; the destructor removes it. On file systems without
// locks a warning is printed and nothing is held. A process cannot lock a folder twice.
class FolderLock {
  public:
    FolderLock() = default;  // holds nothing
    // Throws OutputError with the holder's process id if the lock is taken.
    explicit FolderLock(const std::string& folder, const std::string& set = "");
    FolderLock(FolderLock&& other) noexcept;
    FolderLock& operator=(FolderLock&& other) noexcept;
    ~FolderLock();

    bool held() const { return file >= 0; }
    // Whether a process holds this lock file.
    static bool is_held(const std::string& file);

  private:
    std::string path;
    int file = -1;  // descriptor
};

// Locks an open file by flock(2) until its descriptor is closed. Returns false if another open file
// description holds the lock, true also on file systems without locks.
[[nodiscard]] bool lock_open_file(int file);

}  // namespace knead
