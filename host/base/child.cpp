#include "host/base/child.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>

#include "host/base/errors.h"
#include "host/base/machine.h"

namespace knead {
namespace {

// Appends all input to `said`; false after `limit` [s], if that is above 0.
bool read_all(int from, double limit, std::string& said)
{
    const double start = wall_seconds();
    char part[4096];
    for (;;) {
        const double left = limit - (wall_seconds() - start);
        pollfd ready{from, POLLIN, 0};
        const int answered = poll(&ready, 1, limit > 0 ? int(1e3 * std::max(0.0, left)) : -1);
        if (answered == 0) return false;
        const ssize_t n = answered < 0 ? -1 : read(from, part, sizeof part);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return true;
        if (said.size() < (1 << 20)) said.append(part, std::size_t(n));
    }
}

}  // namespace

int output_of(const std::vector<std::string>& words, std::string& said, double limit)
{
    // Allocate before fork(): in the child, another thread may hold the allocator's lock.
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (const std::string& w : words) arguments.push_back(const_cast<char*>(w.c_str()));
    arguments.push_back(nullptr);
    int ends[2];
    // O_CLOEXEC: children started by other threads must not inherit it, or the pipe would stay
    // open.
    if (pipe2(ends, O_CLOEXEC) != 0) throw ResourceError("no pipe to a child process");
    const pid_t child = fork();
    if (child < 0) throw ResourceError("no child process");
    if (child == 0) {
        dup2(ends[1], 1);
        execvp(arguments[0], arguments.data());
        _exit(127);
    }
    close(ends[1]);
    const bool in_time = read_all(ends[0], limit, said);
    if (!in_time) kill(child, SIGKILL);
    close(ends[0]);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (!in_time) return ended_late;
    return WIFEXITED(status) ? WEXITSTATUS(status) : ended_by_signal + WTERMSIG(status);
}

}  // namespace knead
