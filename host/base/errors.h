// Exit codes, and errors that are not faults of the program.
#pragma once
#include <functional>
#include <stdexcept>

namespace knead {

enum Exit : int {
    exit_ok = 0,
    exit_check = 1,        // a comparison or check failed
    exit_usage = 2,        // command line
    exit_input = 3,        // a file's content
    exit_resource = 4,     // no GPU, or out of memory
    exit_output = 5,       // files that cannot be written
    exit_numbers = 6,      // numerical failure, last good state saved
    exit_device = 7,       // the device was lost
    exit_hangup = 129,     // the terminal was closed, partial results flushed
    exit_interrupt = 130,  // Ctrl-C, partial results flushed
    exit_terminate = 143,  // SIGTERM, the same
};

// Bad input: where (path, and JSON pointer or byte offset), what was expected, what was found.
struct InputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// More particles or nodes than fit in memory. Thrown before anything is allocated.
struct MemoryError : InputError {
    using InputError::InputError;
};

struct UsageError : std::runtime_error {
    using std::runtime_error::runtime_error;
};
struct ResourceError : std::runtime_error {
    using std::runtime_error::runtime_error;
};
struct OutputError : std::runtime_error {
    using std::runtime_error::runtime_error;
};
// One picture cannot be rendered; others may succeed.
struct PictureError : std::runtime_error {
    using std::runtime_error::runtime_error;
};
struct DeviceLost : std::runtime_error {
    using std::runtime_error::runtime_error;
};

// Runs `action`; converts exceptions to a message on stderr and an exit code.
int run_and_report(const std::function<int()>& action);

}  // namespace knead
