// Standard error without what libraries print there, while they are expected to fail.
#pragma once

namespace knead {

// While one lives, what the process writes to its standard error goes nowhere. One at a time.
class QuietStderr {
  public:
    explicit QuietStderr(bool quiet = true);
    ~QuietStderr();
    QuietStderr(const QuietStderr&) = delete;

    // Standard error is itself again at once, for what this program has to say; any thread.
    static void lift();
};

}  // namespace knead
