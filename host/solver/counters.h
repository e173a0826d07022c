// What a GPU did, by its own counters.
#pragma once
#include <functional>
#include <string>
#include <vector>

namespace knead {

// What one stretch of work came to.
struct DeviceWork {
    double instructions = 0;  // of warps
    double memory_bytes = 0;  // to and from the device's memory
    double cache_bytes = 0;   // to and from the cache of level 2
    double cycles = 0;        // of a multiprocessor
    double seconds = 0;

    double clock() const { return seconds > 0 ? cycles / seconds : 0; }  // [1/s]
    DeviceWork& operator+=(const DeviceWork& more);
};
DeviceWork operator*(double factor, const DeviceWork& work);

struct StageWork {
    std::string name;
    DeviceWork work;
};

// Runs one stage, with something around it.
using Watch = std::function<void(const char* stage, const std::function<void()>& run)>;

// What each stage counts that `work` hands to its argument, in that order; each must wait for its
// own end. By CUPTI, on this thread's device, on which nothing else may run; `work` is called
// as often as the counters have to be read. Throws std::runtime_error: why nothing can be counted.
std::vector<StageWork> counted(const std::function<void(const Watch&)>& work);

}  // namespace knead
