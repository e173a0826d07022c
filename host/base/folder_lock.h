// A folder that one process at a time writes into.
#pragma once
#include <string>

namespace knead {

constexpr const char* lock_name = ".knead-lock";

// Reserves a folder, or the files in it that `set` names, for one process: a hidden file whose name
// ends in lock_name holds the process's number, under flock(2), so that a crash releases it. The
// destructor removes the file; a crash leaves it, and the next lock takes it over. Where the file
// system has no locks, a message says so and nothing is held. A process cannot lock a folder twice.
class FolderLock {
  public:
    FolderLock() = default;  // holds nothing
    // Throws OutputError that names the process where another one holds the lock.
    explicit FolderLock(const std::string& folder, const std::string& set = "");
    FolderLock(FolderLock&& other) noexcept;
    FolderLock& operator=(FolderLock&& other) noexcept;
    ~FolderLock();

    bool held() const { return file >= 0; }
    // Whether a process holds the lock that this file is of.
    static bool is_held(const std::string& file);

  private:
    std::string path;
    int file = -1;  // its descriptor
};

}  // namespace knead
