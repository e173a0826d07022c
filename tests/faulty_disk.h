// A disk with faults: what pwrite(2) and fdatasync(2) of a test's program do. Its files are written
// by these calls alone (host/files/chunk_file.cpp).
#pragma once
#include <dlfcn.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <thread>

namespace knead {

struct FaultyDisk {
    std::atomic<int> write_error = 0, sync_error = 0;  // errno
    std::atomic<bool> interrupts = false;              // each second call is interrupted
    std::atomic<std::size_t> most = ~std::size_t(0);   // bytes of a call
    std::atomic<bool> stands = false;                  // calls wait
    std::atomic<long> calls = 0;
    void reset()
    {
        write_error = sync_error = 0, interrupts = stands = false, most = ~std::size_t(0);
        calls = 0;
    }
    // Returns the errno that the call ends with; 0: none.
    int begin(int error)
    {
        const long number = ++calls;
        while (stands) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return interrupts && number % 2 != 0 ? EINTR : error;
    }
};
inline FaultyDisk disk;

}  // namespace knead

// Weak, so that each test that has such a disk can define them.
extern "C" __attribute__((weak)) ssize_t pwrite(int file, const void* from, size_t size, off_t at)
{
    using namespace knead;
    static const auto call =
        reinterpret_cast<ssize_t (*)(int, const void*, size_t, off_t)>(dlsym(RTLD_NEXT, "pwrite"));
    if ((errno = disk.begin(disk.write_error)) != 0) return -1;
    return call(file, from, std::min<std::size_t>(size, disk.most), at);
}

extern "C" __attribute__((weak)) int fdatasync(int file)
{
    using namespace knead;
    static const auto call = reinterpret_cast<int (*)(int)>(dlsym(RTLD_NEXT, "fdatasync"));
    if ((errno = disk.begin(disk.sync_error)) != 0) return -1;
    return call(file);
}
