// Each thread block copies one piece of a range, in 16-byte words if the range allows.
#include <cstdint>

#include "cuda/device/copy.cuh"
#include "cuda/device/launch.cuh"

namespace knead::gpu {
namespace {

constexpr int threads = 256, words_each = 4;
constexpr std::size_t piece = std::size_t(threads) * words_each * sizeof(uint4);  // [bytes]

struct Ranges {
    CopiedRange each[most_ranges];
    int end[most_ranges];  // cumulative number of thread blocks
};

template <class Word>
__device__ void copy_piece(const CopiedRange& range, std::size_t at)
{
    Word* to = static_cast<Word*>(range.to) + at / sizeof(Word);
    const Word* from = static_cast<const Word*>(range.from) + at / sizeof(Word);
    const std::size_t left = range.bytes - at;
    const int count = int((left < piece ? left : piece) / sizeof(Word));
    constexpr int steps = int(piece / sizeof(Word) / threads);
#pragma unroll 1
    for (int step = 0; step < steps; step += words_each) {
        Word held[words_each];
#pragma unroll
        for (int k = 0; k < words_each; ++k) {
            const int i = (step + k) * threads + int(threadIdx.x);
            if (i < count) held[k] = __ldcs(from + i);
        }
#pragma unroll
        for (int k = 0; k < words_each; ++k) {
            const int i = (step + k) * threads + int(threadIdx.x);
            if (i < count) to[i] = held[k];
        }
    }
}

__global__ void __launch_bounds__(threads) copy_kernel(const __grid_constant__ Ranges ranges)
{
    int r = 0;
    while (int(blockIdx.x) >= ranges.end[r]) ++r;
    const CopiedRange& range = ranges.each[r];
    const std::size_t at = std::size_t(int(blockIdx.x) - (r ? ranges.end[r - 1] : 0)) * piece;
    const auto apart = reinterpret_cast<std::uintptr_t>(range.to) |
                       reinterpret_cast<std::uintptr_t>(range.from) | range.bytes;
    if (apart % sizeof(uint4) == 0)
        copy_piece<uint4>(range, at);
    else
        copy_piece<unsigned>(range, at);
}

}  // namespace

void copy(const char* name, std::span<const CopiedRange> of, cudaStream_t stream)
{
    Ranges ranges{};
    int r = 0, blocks = 0;
    for (const CopiedRange& range : of) {
        if (r == most_ranges || range.bytes % sizeof(unsigned) != 0)
            throw std::invalid_argument("copy: too many ranges, or not of whole words");
        blocks += int((range.bytes + piece - 1) / piece);
        ranges.each[r] = range, ranges.end[r++] = blocks;
    }
    launch(name, copy_kernel, blocks, threads, stream, ranges);
}

}  // namespace knead::gpu
