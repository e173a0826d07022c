// What this machine is, as far as results depend on it.
#pragma once
#include <cstddef>
#include <string>

namespace knead {

std::string host_name();
std::string cpu_name();
int cpu_count();
std::size_t total_memory();  // [bytes]
std::string compiler_name();
std::string knead_version();
std::string utc_now();     // 2025-01-31T12:00:00Z
double process_seconds();  // CPU time of all threads since the start [s]

}  // namespace knead
