// What a benchmark must know of the device it runs on, measured in the same run.
#pragma once
#include <cstddef>
#include <string>

#include "host/session/backend.h"

namespace knead {

struct DeviceInfo {
    std::string name;         // of the GPU or the CPU
    std::size_t memory = 0;   // [bytes]
    int multiprocessors = 0;  // 0: a CPU
    std::size_t cache = 0;    // of level 2, a GPU's [bytes]; 0: not told
    double copy = 0;          // bytes read and written per second by a plain copy
};

// `threads` is for the CPU; 0: all. Throws std::runtime_error where the device fails.
DeviceInfo device_facts(Device device, int threads);

// Bytes that could be taken on the device now.
std::size_t free_memory(Device device);

namespace gpu {
DeviceInfo facts_of(int device);
std::size_t free_memory(int device);
}  // namespace gpu

}  // namespace knead
