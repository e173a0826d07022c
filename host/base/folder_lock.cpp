#include "host/base/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <thread>
#include <utility>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/machine.h"
#include "host/base/print.h"

namespace knead {
namespace fs = std::filesystem;
namespace {

// Part of a set's name used in the name of its lock [bytes].
constexpr std::size_t longest_lock_set = 200;

// "process 42", or "process 42 on NAME" on another machine: the holder, read from the lock file.
std::string holder(int lock)
{
    char text[300] = {};
    const ssize_t size = ::pread(lock, text, sizeof text - 1, 0);
    const std::string_view all(text, std::size_t(std::max(ssize_t(0), size)));
    const std::size_t blank = all.find(' '), end = all.find('\n');
    if (blank == std::string_view::npos || end == std::string_view::npos || blank > end)
        return "another process";
    const std::string_view host = all.substr(blank + 1, end - blank - 1);
    return "process " + std::string(all.substr(0, blank)) +
           (host == host_name() ? "" : " on " + std::string(host));
}

// Opens or creates a lock file; < 0 on failure. Another user's file, left by a crash, can be locked
// but not written.
int open_lock(const std::string& path)
{
    constexpr int flags = O_CREAT | O_CLOEXEC | O_NOFOLLOW;
    const int file = ::open(path.c_str(), flags | O_RDWR, 0666);
    if (file >= 0 || errno != EACCES) return file;
    return ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
}

// Returns 0, EWOULDBLOCK if another process holds the lock, or the errno of a file system without
// locks.
int try_lock(int file)
{
    while (::flock(file, LOCK_EX | LOCK_NB) != 0)
        if (errno != EINTR) return errno;
    return 0;
}

// True if `path` still names the open file: the previous holder may have removed it.
bool is_at(int file, const std::string& path)
{
    struct stat opened, named;
    return ::fstat(file, &opened) == 0 && ::stat(path.c_str(), &named) == 0 &&
           opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

}  // namespace

FolderLock::FolderLock(const std::string& folder, const std::string& set)
{
    const EndHeld held_back;  // a signal must not leave the file behind
    const std::string name = set.empty() ? "" : "." + set.substr(0, longest_lock_set);
    path = (fs::path(folder) / (name + lock_name)).string();
    const auto refuse = [this](int reason) {
        throw OutputError(path + ": cannot be written: " + std::strerror(reason));
    };
    const std::string where = set.empty() ? folder : (fs::path(folder) / set).string();
    int tries = 10;  // leftovers() in another process may hold the lock briefly
    for (;;) {
        const int opened = open_lock(path);
        if (opened < 0) refuse(errno);
        const int reason = try_lock(opened);
        if (reason == 0 && is_at(opened, path)) {
            file = opened;
            break;
        }
        const std::string who = holder(opened);
        if (reason != 0 && reason != EWOULDBLOCK) ::unlink(path.c_str());
        ::close(opened);
        if (reason == 0) continue;
        if (reason != EWOULDBLOCK) {
            std::fprintf(stderr,
                         "knead: %s: this file system has no locks (%s); nothing keeps another "
                         "process from writing there meanwhile\n",
                         where.c_str(), std::strerror(reason));
            return;
        }
        if (--tries == 0)
            throw OutputError(where + ": " + who +
                              " is writing there; wait until it has ended, or choose another " +
                              (set.empty() ? "folder" : "name"));
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    const std::string who = std::to_string(getpid()) + " " + host_name() + "\n";
    if ((::fcntl(file, F_GETFL) & O_ACCMODE) != O_RDWR) return;
    const int reason = ::ftruncate(file, 0) == 0 ? write_all(file, who) : errno;
    if (reason == 0) return;
    ::unlink(path.c_str());
    ::close(file);
    refuse(reason);
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : path(std::move(other.path)), file(std::exchange(other.file, -1))
{
}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept
{
    std::swap(path, other.path), std::swap(file, other.file);
    return *this;
}

FolderLock::~FolderLock()
{
    if (file < 0) return;
    ::unlink(path.c_str());  // unlink while locked: afterwards the file may be another process's
                             // lock
    ::close(file);
}

bool lock_open_file(int file)
{
    for (int tries = 10;; --tries) {  // is_held() in another process may hold the lock briefly
        const int reason = try_lock(file);
        if (reason != EWOULDBLOCK) return true;
        if (tries == 1) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
}

bool FolderLock::is_held(const std::string& path)
{
    const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
    if (file < 0) return true;
    const bool held = ::flock(file, LOCK_SH | LOCK_NB) != 0;
    ::close(file);
    return held;
}

}  // namespace knead
