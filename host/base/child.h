// Runs other programs to completion.
#pragma once
#include <string>
#include <vector>

namespace knead {

constexpr int ended_late = 124;       // as timeout(1) returns
constexpr int ended_by_signal = 128;  // plus the signal number, as shells return

// Runs a program and stores up to 1 MiB of its stdout in `said`; its stderr is inherited. If
// `limit` [s] is above 0, a program that has not closed its stdout by then is killed. Returns its
// exit code; 127: not found; ended_late: killed at the limit; ended_by_signal + n: ended by signal
// n. Thread-safe. Throws ResourceError.
int output_of(const std::vector<std::string>& words, std::string& said, double limit = 0);

}  // namespace knead
