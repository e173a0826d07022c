#include "host/bench/child.h"

#include <sys/wait.h>
#include <unistd.h>

#include "host/base/errors.h"

namespace knead {

int output_of(const std::vector<std::string>& words, std::string& said)
{
    int ends[2];
    if (pipe(ends) != 0) throw ResourceError("no pipe for a peer");
    const pid_t child = fork();
    if (child < 0) throw ResourceError("no process for a peer");
    if (child == 0) {
        dup2(ends[1], 1);
        close(ends[0]), close(ends[1]);
        std::vector<char*> arguments;
        for (const std::string& w : words) arguments.push_back(const_cast<char*>(w.c_str()));
        arguments.push_back(nullptr);
        execvp(arguments[0], arguments.data());
        _exit(127);
    }
    close(ends[1]);
    char part[4096];
    for (ssize_t n; (n = read(ends[0], part, sizeof part)) > 0;)
        if (said.size() < (1 << 20)) said.append(part, std::size_t(n));
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
}

}  // namespace knead
