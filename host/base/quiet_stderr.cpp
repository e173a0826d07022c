#include "host/base/quiet_stderr.h"

#include <mutex>

#ifndef _WIN32
#include <fcntl.h>
#include <unistd.h>
#endif

namespace knead {
#ifndef _WIN32
namespace {

std::mutex stderr_lock;
// Duplicate of the real standard error while it is redirected; -1: not redirected.
int real_stderr = -1;

}  // namespace

QuietStderr::QuietStderr(bool quiet)
{
    const std::lock_guard held(stderr_lock);
    if (!quiet || real_stderr >= 0) return;
    const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
    if (nowhere < 0) return;
    real_stderr = ::fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
    if (real_stderr >= 0) ::dup2(nowhere, STDERR_FILENO);
    ::close(nowhere);
}

QuietStderr::~QuietStderr() { lift(); }

void QuietStderr::lift()
{
    const std::lock_guard held(stderr_lock);
    if (real_stderr < 0) return;
    ::dup2(real_stderr, STDERR_FILENO);
    ::close(real_stderr);
    real_stderr = -1;
}
#else
QuietStderr::QuietStderr(bool) {}
QuietStderr::~QuietStderr() = default;
void QuietStderr::lift() {}
#endif
}  // namespace knead
