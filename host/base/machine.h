// The machine, as far as results depend on it.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace knead {

std::string host_name();
std::string cpu_name();
// Resources of this process: those of the machine, or of its container if lower.
int cpu_count();                 // threads that can run at once
std::size_t total_memory();      // [bytes]
std::size_t available_memory();  // currently free part of it [bytes]
std::string compiler_name();
std::string knead_version();
std::string knead_commit();  // of the build's source, "-dirty" if modified; or "unknown"
std::string utc_now();       // 2025-01-31T12:00:00Z
double wall_seconds();       // since an arbitrary start, steady [s]
// Sets an environment variable if unset, for libraries that read it once. Not thread-safe: call
// while there is one thread.
void default_variable(const char* name, const char* value);
double process_seconds();  // CPU time of all threads since the start [s]
double thread_seconds();   // of the calling thread [s]

// Current state of a GPU as reported by the driver. Clocks are momentary: an idle GPU clocks down.
struct GpuState {
    std::string name, driver;
    unsigned clock = 0, max_clock = 0, memory_clock = 0;  // [MHz]; 0: not reported
    double power_limit = 0;                               // [W]; 0: not reported
};
// `bus`: bus id as reported by CUDA. Empty without a driver.
std::optional<GpuState> gpu_state(const std::string& bus);
// Bus id of the current CUDA device of this thread; "" without one.
std::string gpu_bus();

// Everything that results depend on beyond the scene: date, machine, build and, if `gpu`, GPU
// state.
nlohmann::json machine_facts(bool gpu);

}  // namespace knead
