// A library to be loaded before the program's own (LD_PRELOAD), for which the n-th call that opens,
// reads, writes, flushes, closes, renames or makes a file fails. It counts what is below one folder
// alone, so that drivers and fonts are left alone. glibc on 64 bits.
//     FAIL_UNDER   the folder's absolute path
//     FAIL_AT      n, from 1
//     FAIL_SIGNAL  a signal's number: the call does not fail, but the program receives that
//     FAIL_LOCKS   if set, flock(2) fails as where a file system has no locks
//     FAIL_LOG     receives one line, "CALL PATH", where a call failed
// Removing files never fails: it is how the program puts things right.
#include <dlfcn.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <climits>

namespace {

template <class Call>
Call next(const char* name)
{
    return reinterpret_cast<Call>(dlsym(RTLD_NEXT, name));
}

// Whether the path, taken from the working directory, lies below the folder.
bool concerns(const char* path)
{
    const char* const folder = getenv("FAIL_UNDER");
    if (!folder || !path) return false;
    char whole[2 * PATH_MAX];
    char here[PATH_MAX] = "";
    if (path[0] != '/' && !getcwd(here, sizeof here)) return false;
    snprintf(whole, sizeof whole, "%s%s%s", here, path[0] == '/' ? "" : "/", path);
    return strncmp(whole, folder, strlen(folder)) == 0;
}

void log_failure(const char* call, const char* path)
{
    const char* const log = getenv("FAIL_LOG");
    static const auto real_open = next<int (*)(const char*, int, ...)>("open");
    static const auto real_write = next<ssize_t (*)(int, const void*, size_t)>("write");
    static const auto real_close = next<int (*)(int)>("close");
    const int file = log ? real_open(log, O_WRONLY | O_CREAT | O_APPEND, 0666) : -1;
    if (file < 0) return;
    char line[2 * PATH_MAX];
    const int size = snprintf(line, sizeof line, "%s %s\n", call, path);
    if (real_write(file, line, size_t(size)) < 0) abort();
    real_close(file);
}

// Whether this call, the next one that counts, is the one to fail.
bool fails(const char* call, const char* path)
{
    static std::atomic<long> calls{0};
    const char* const at = getenv("FAIL_AT");
    if (!at || !concerns(path) || ++calls != atol(at)) return false;
    log_failure(call, path);
    if (const char* const number = getenv("FAIL_SIGNAL")) {
        kill(getpid(), atoi(number));
        return false;
    }
    errno = ENOSPC;
    return true;
}

bool fails(const char* call, int file)
{
    char link[64], path[PATH_MAX];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    const ssize_t size = readlink(link, path, sizeof path - 1);
    if (size <= 0) return false;
    path[size] = 0;
    return fails(call, path);
}

const char* opening(int flags) { return flags & (O_WRONLY | O_RDWR) ? "create" : "open"; }

mode_t mode_of(int flags, va_list more) { return flags & O_CREAT ? va_arg(more, mode_t) : 0; }

}  // namespace

extern "C" {

int open(const char* path, int flags, ...)
{
    va_list more;
    va_start(more, flags);
    const mode_t mode = mode_of(flags, more);
    va_end(more);
    if (fails(opening(flags), path)) return -1;
    return next<int (*)(const char*, int, ...)>("open")(path, flags, mode);
}

int open64(const char* path, int flags, ...)
{
    va_list more;
    va_start(more, flags);
    const mode_t mode = mode_of(flags, more);
    va_end(more);
    if (fails(opening(flags), path)) return -1;
    return next<int (*)(const char*, int, ...)>("open64")(path, flags, mode);
}

FILE* fopen(const char* path, const char* how)
{
    if (fails(strpbrk(how, "wa+") ? "create" : "open", path)) return nullptr;
    return next<FILE* (*)(const char*, const char*)>("fopen")(path, how);
}

FILE* fopen64(const char* path, const char* how)
{
    if (fails(strpbrk(how, "wa+") ? "create" : "open", path)) return nullptr;
    return next<FILE* (*)(const char*, const char*)>("fopen64")(path, how);
}

ssize_t read(int file, void* to, size_t size)
{
    if (fails("read", file)) return -1;
    return next<ssize_t (*)(int, void*, size_t)>("read")(file, to, size);
}

ssize_t write(int file, const void* from, size_t size)
{
    if (fails("write", file)) return -1;
    return next<ssize_t (*)(int, const void*, size_t)>("write")(file, from, size);
}

ssize_t pread(int file, void* to, size_t size, off_t at)
{
    if (fails("pread", file)) return -1;
    return next<ssize_t (*)(int, void*, size_t, off_t)>("pread")(file, to, size, at);
}

ssize_t pwrite(int file, const void* from, size_t size, off_t at)
{
    if (fails("pwrite", file)) return -1;
    return next<ssize_t (*)(int, const void*, size_t, off_t)>("pwrite")(file, from, size, at);
}

ssize_t copy_file_range(int from, off64_t* at, int to, off64_t* there, size_t size, unsigned flags)
{
    if (fails("copy", to)) return -1;
    using Call = ssize_t (*)(int, off64_t*, int, off64_t*, size_t, unsigned);
    return next<Call>("copy_file_range")(from, at, to, there, size, flags);
}

int ftruncate(int file, off_t size)
{
    if (fails("cut", file)) return -1;
    return next<int (*)(int, off_t)>("ftruncate")(file, size);
}

int fdatasync(int file)
{
    if (fails("fdatasync", file)) return -1;
    return next<int (*)(int)>("fdatasync")(file);
}

int linkat(int from, const char* name, int to, const char* path, int flags)
{
    if (fails("create", path)) return -1;
    return next<int (*)(int, const char*, int, const char*, int)>("linkat")(from, name, to, path,
                                                                            flags);
}

int fsync(int file)
{
    if (fails("fsync", file)) return -1;
    return next<int (*)(int)>("fsync")(file);
}

int close(int file)
{
    const bool failed = fails("close", file);
    const int ended = next<int (*)(int)>("close")(file);
    if (failed) errno = ENOSPC;
    return failed ? -1 : ended;
}

int flock(int file, int how)
{
    if (getenv("FAIL_LOCKS")) {
        errno = ENOLCK;
        return -1;
    }
    return next<int (*)(int, int)>("flock")(file, how);
}

int rename(const char* from, const char* to)
{
    if (fails("rename", to)) return -1;
    return next<int (*)(const char*, const char*)>("rename")(from, to);
}

int mkdir(const char* path, mode_t mode)
{
    if (fails("mkdir", path)) return -1;
    return next<int (*)(const char*, mode_t)>("mkdir")(path, mode);
}

}  // extern "C"
