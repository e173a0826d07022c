// Writing to descriptors and to standard output.
#pragma once
#include <string_view>

namespace knead {

// Writes all bytes to an open file. Returns 0 or errno.
int write_all(int file, std::string_view bytes);

// Writes to standard output, unbuffered. Does not throw, so that the command completes its other
// work: after a failure nothing more is written, and exit_code_after_printing() reports it.
void print(std::string_view text);
// Returns `code` unless print() failed; then prints the reason and replaces exit_ok and exit_check
// by exit_output.
int exit_code_after_printing(int code);

}  // namespace knead
