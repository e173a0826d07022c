// The benchmarked device: name, memory, copy rate.
#include <algorithm>

#include "cuda/device/device_array.cuh"
#include "cuda/device/launch.cuh"
#include "host/bench/device.h"

namespace knead {
namespace gpu {

namespace {

struct Timer {
    cudaEvent_t from = nullptr, to = nullptr;
    Timer()
    {
        check(cudaEventCreate(&from), "event");
        check(cudaEventCreate(&to), "event");
    }
    Timer(const Timer&) = delete;
    ~Timer()
    {
        cudaEventDestroy(from);
        cudaEventDestroy(to);
    }
};

// Bytes read and written per second by cudaMemcpy within the device; the best of several, of arrays
// far larger than the caches.
double copy_rate(std::size_t bytes)
{
    DeviceArray<unsigned char> from(bytes), to(bytes);
    check(cudaMemset(from.data(), 1, bytes), "copy");
    const Timer timer;
    float best = 1e30f;
    for (int pass = 0; pass < 12; ++pass) {
        check(cudaEventRecord(timer.from), "copy");
        check(cudaMemcpyAsync(to.data(), from.data(), bytes, cudaMemcpyDeviceToDevice), "copy");
        check(cudaEventRecord(timer.to), "copy");
        check(cudaEventSynchronize(timer.to), "copy");
        float milliseconds = 0;
        check(cudaEventElapsedTime(&milliseconds, timer.from, timer.to), "copy");
        if (pass > 1) best = std::min(best, milliseconds);
    }
    return 2 * double(bytes) / (1e-3 * double(best));
}

}  // namespace

DeviceInfo facts_of(int device)
{
    check(cudaSetDevice(device), "device");
    cudaDeviceProp properties;
    check(cudaGetDeviceProperties(&properties, device), "device");
    const std::size_t max = std::size_t(1) << 30;
    return {properties.name, properties.totalGlobalMem, properties.multiProcessorCount,
            std::size_t(properties.l2CacheSize), copy_rate(std::min(max, free_memory(device) / 4))};
}

std::size_t free_memory(int device)
{
    std::size_t free = 0, total = 0;
    check(cudaSetDevice(device), "device");
    check(cudaMemGetInfo(&free, &total), "memory");
    return free;
}

}  // namespace gpu

}  // namespace knead
