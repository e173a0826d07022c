#include "host/files/byte_window.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "host/base/errors.h"

namespace knead {

OpenFile::OpenFile(const std::string& name) : path(name)
{
    descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) fail(errno);
    const off_t end = ::lseek(descriptor, 0, SEEK_END);
    if (end < 0) {
        const int reason = errno;
        ::close(descriptor);
        fail(reason);
    }
    bytes = std::size_t(end);
}

void OpenFile::fail(int reason) const
{
    throw InputError(path + ": cannot be read: " + std::strerror(reason));
}

OpenFile::~OpenFile() { ::close(descriptor); }

void OpenFile::read(std::size_t from, std::size_t size, char* to) const
{
    while (size > 0) {
        const ssize_t got = ::pread(descriptor, to, size, off_t(from));
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail(errno);
        if (got == 0) throw InputError(path + ": cannot be read: it became shorter meanwhile");
        from += std::size_t(got), to += got, size -= std::size_t(got);
    }
}

void ByteWindow::move_to(std::size_t offset, std::size_t count) const
{
    constexpr std::size_t window_bytes = 1 << 18;
    window.resize(std::min(std::max(window_bytes, count), all - offset));
    from = offset;
    file->read(offset, window.size(), window.data());
}

}  // namespace knead
