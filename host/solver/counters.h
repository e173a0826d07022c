// Hardware counters of the GPU.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace knead {

// Counters over one range of work.
struct DeviceWork {
    double instructions = 0;  // of warps
    double memory_bytes = 0;  // device memory traffic
    double cache_bytes = 0;   // L2 cache traffic
    double cycles = 0;        // elapsed on a multiprocessor
    double seconds = 0;

    double clock() const { return seconds > 0 ? cycles / seconds : 0; }  // [1/s]
    DeviceWork& operator+=(const DeviceWork& more);
};
DeviceWork operator*(double factor, const DeviceWork& work);

struct StageWork {
    std::string name;
    DeviceWork work;
};

// Wrapper around one stage: must call run() once.
using StageObserver = std::function<void(const char* stage, const std::function<void()>& run)>;

// Counts each stage that `work` runs through the StageObserver, in that order. Each stage must
// synchronise before it returns. Uses CUPTI on the device of the calling thread, on which nothing
// else may run; `work` is called once per counter pass. Throws std::runtime_error with the reason
// if counting is impossible.
std::vector<StageWork> counted(const std::function<void(const StageObserver&)>& work);

}  // namespace knead
