// Copies of several ranges on the device by one launch: where each is short, what they cost is the
// calls of the host.
#pragma once
#include <cuda_runtime.h>

#include <cstddef>
#include <span>

namespace knead::gpu {

struct CopiedRange {
    void* to;
    const void* from;
    std::size_t bytes;  // a multiple of 4, as both addresses are; none: left out
};
constexpr int most_ranges = 16;
// Throws std::invalid_argument for more of them, or for bytes that are no whole words.
void copy(const char* name, std::span<const CopiedRange> ranges, cudaStream_t stream);

}  // namespace knead::gpu
