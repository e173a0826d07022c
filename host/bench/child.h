// Other programs, run to their end.
#pragma once
#include <string>
#include <vector>

namespace knead {

// Runs a program and gives what it wrote to stdout, 1 MiB of it at most; its messages go where ours
// go. Returns its exit code; 127: it is not there. Throws ResourceError.
int output_of(const std::vector<std::string>& words, std::string& said);

}  // namespace knead
