// Bytes into descriptors; data on the standard output.
#pragma once
#include <string_view>

namespace knead {

// Writes all to an open file: 0, or why not (errno).
int write_all(int file, std::string_view bytes);

// Writes to the standard output at once. A failure does not throw, so that a verb still does the
// rest of its work: nothing more is written, and exit_code_after_printing() reports it.
void print(std::string_view text);
// `code`, unless print() failed: then a message says why, and exit_ok and exit_check become
// exit_output. Other codes stay.
int exit_code_after_printing(int code);

}  // namespace knead
