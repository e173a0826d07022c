// Other programs, run to their end.
#pragma once
#include <string>
#include <vector>

namespace knead {

constexpr int ended_late = 124;       // as timeout(1) says it
constexpr int ended_by_signal = 128;  // plus its number, as a shell says it

// Runs a program and gives what it wrote to stdout, 1 MiB of it at most; its messages go where ours
// go. One that has not closed its stdout after `limit` [s], if that is above 0, is killed. Returns
// its exit code; 127: it is not there; ended_late: killed so; ended_by_signal + n: by signal n.
// May be called from several threads at a time. Throws ResourceError.
int output_of(const std::vector<std::string>& words, std::string& said, double limit = 0);

}  // namespace knead
