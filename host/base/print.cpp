#include "host/base/print.h"

#include <poll.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include "host/base/errors.h"

namespace knead {
namespace {

std::atomic<int> print_failure{0};  // first errno of print()

}  // namespace

int write_all(int file, std::string_view bytes)
{
    for (std::size_t done = 0; done < bytes.size();) {
        const ssize_t step = ::write(file, bytes.data() + done, bytes.size() - done);
        if (step > 0) {
            done += std::size_t(step);
        } else if (step < 0 && errno == EAGAIN) {  // a pipe set to non-blocking by another program
            pollfd ready{file, POLLOUT, 0};
            ::poll(&ready, 1, -1);
        } else if (step == 0 || errno != EINTR) {
            return step == 0 ? ENOSPC : errno;
        }
    }
    return 0;
}

void print(std::string_view text)
{
    if (print_failure != 0) return;
    std::fflush(stdout);  // output of libraries first
    print_failure = write_all(STDOUT_FILENO, text);
}

int exit_code_after_printing(int code)
{
    if (print_failure == 0) return code;
    std::fprintf(stderr, "knead: the standard output cannot be written: %s\n",
                 std::strerror(print_failure));
    return code == exit_ok || code == exit_check ? int(exit_output) : code;
}

}  // namespace knead
