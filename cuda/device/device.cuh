// Selection of the device.
#pragma once
#include <stdexcept>
#include <string>

#include "cuda/device/launch.cuh"

namespace knead::gpu {

// Selects a device for the calling thread and returns its number; -1: the current one. Throws
// std::runtime_error if there is no such device.
inline int chosen(int device)
{
    int count = 0;
    if (cudaGetDeviceCount(&count) != cudaSuccess || count == 0)
        throw std::runtime_error("no CUDA device");
    if (device == -1) check(cudaGetDevice(&device), "device");
    if (device < 0 || device >= count)
        throw std::runtime_error("no CUDA device " + std::to_string(device) + " among " +
                                 std::to_string(count));
    check(cudaSetDevice(device), "device");
    return device;
}

inline int multiprocessors(int device)
{
    int n = 0;
    check(cudaDeviceGetAttribute(&n, cudaDevAttrMultiProcessorCount, device), "device");
    return n;
}

}  // namespace knead::gpu
