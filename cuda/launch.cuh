// The one place where kernels start: named for the profiler, checked for errors.
#pragma once
#include <cuda_runtime.h>

#include <atomic>
#include <nvtx3/nvtx3.hpp>
#include <stdexcept>
#include <string>

namespace knead::gpu {

struct ProfilerDomain {
    static constexpr const char* name = "knead";
};
using ProfilerRange = nvtx3::scoped_range_in<ProfilerDomain>;

inline void check(cudaError_t e, const char* what)
{
    if (e != cudaSuccess)
        throw std::runtime_error(std::string("cuda: ") + what + ": " + cudaGetErrorString(e));
}

// Wherever the host waits for the device, it does so here, and it is counted.
inline std::atomic<long> waits = 0;
inline void wait(cudaStream_t stream, const char* what)
{
    ++waits;
    check(cudaStreamSynchronize(stream), what);
}
inline void wait(cudaEvent_t event, const char* what)
{
    ++waits;
    check(cudaEventSynchronize(event), what);
}

// `name` is the profiler range and the error text. No blocks: nothing to do.
template <class... Parameters, class... Arguments>
void launch(const char* name, void (*kernel)(Parameters...), int blocks, int threads,
            cudaStream_t stream, const Arguments&... arguments)
{
    if (blocks == 0) return;
    const ProfilerRange range{name};
    kernel<<<unsigned(blocks), unsigned(threads), 0, stream>>>(arguments...);
    check(cudaGetLastError(), name);
}

inline int blocks_for(int count, int threads) { return (count + threads - 1) / threads; }

}  // namespace knead::gpu
