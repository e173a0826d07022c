// Suppresses the messages of libraries on standard error while they are expected to fail.
#pragma once

namespace knead {

// Redirects the process's standard error to /dev/null during its lifetime. One instance at a time.
class QuietStderr {
  public:
    explicit QuietStderr(bool quiet = true);
    ~QuietStderr();
    QuietStderr(const QuietStderr&) = delete;

    // Restores standard error immediately, for messages of this program. Thread-safe.
    static void lift();
};

}  // namespace knead
