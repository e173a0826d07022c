// What this machine is, as far as results depend on it.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace knead {

std::string host_name();
std::string cpu_name();
// What this process may use: of the machine, or of its container where that has less.
int cpu_count();                 // threads that can run at once
std::size_t total_memory();      // [bytes]
std::size_t available_memory();  // of it free now [bytes]
std::string compiler_name();
std::string knead_version();
std::string knead_commit();  // of the build's source, "-dirty" where it was changed; or "unknown"
std::string utc_now();       // 2025-01-31T12:00:00Z
double wall_seconds();       // since some moment [s]
// Sets a variable of the environment that is not set yet: for libraries that read it once. To be
// called while there is one thread.
void default_variable(const char* name, const char* value);
double process_seconds();  // CPU time of all threads since the start [s]
double thread_seconds();   // of the calling one [s]

// What the driver says of a GPU now. Clocks are those of the moment: a GPU at rest slows down.
struct GpuState {
    std::string name, driver;
    unsigned clock = 0, max_clock = 0, memory_clock = 0;  // [MHz]; 0: not told
    double power_limit = 0;                               // [W]; 0: not told
};
// By the bus id that CUDA tells of a device. Nothing where no driver answers.
std::optional<GpuState> gpu_state(const std::string& bus);
// Bus id of the CUDA device that this thread uses; "" without one.
std::string gpu_bus();

// What results depend on and no scene says: date, machine, build and, where `gpu` is, its state.
nlohmann::json machine_facts(bool gpu);

}  // namespace knead
