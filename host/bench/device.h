// Properties of the benchmarked device, measured in the same run.
#pragma once
#include <cstddef>
#include <string>

#include "host/session/backend.h"

namespace knead {

struct DeviceInfo {
    std::string name;         // of the GPU or the CPU
    std::size_t memory = 0;   // [bytes]
    int multiprocessors = 0;  // 0: a CPU
    std::size_t cache = 0;    // L2 cache of a GPU [bytes]; 0: unknown
    double copy = 0;          // bytes read and written per second by a plain copy
};

// `threads`: CPU threads; 0: all. Throws std::runtime_error on a device error.
DeviceInfo device_facts(Device device, int threads);

// Free memory of the device [bytes].
std::size_t free_memory(Device device);

namespace gpu {
DeviceInfo facts_of(int device);
std::size_t free_memory(int device);
}  // namespace gpu

}  // namespace knead
