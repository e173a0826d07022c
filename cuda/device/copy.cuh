// Copies several ranges on the device in one launch: for short ranges the host calls dominate the
// cost.
#pragma once
#include <cuda_runtime.h>

#include <cstddef>
#include <span>

namespace knead::gpu {

struct CopiedRange {
    void* to;
    const void* from;
    std::size_t bytes;  // a multiple of 4, like both addresses; 0: skipped
};
constexpr int most_ranges = 16;
// Throws std::invalid_argument for more ranges, or for sizes that are not multiples of 4.
void copy(const char* name, std::span<const CopiedRange> ranges, cudaStream_t stream);

}  // namespace knead::gpu
