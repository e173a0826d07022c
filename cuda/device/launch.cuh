// The one place where kernels start: named for the profiler, checked for errors.
#pragma once
#include <cuda_runtime.h>

#include <atomic>
#include <nv/target>
#include <stdexcept>
#include <string>

namespace knead::gpu {

// A range of the domain "knead" in a profiler's picture, on the calling thread, while it lives.
class ProfilerRange {
  public:
    explicit ProfilerRange(const char* name);
    ~ProfilerRange();
    ProfilerRange(const ProfilerRange&) = delete;
    ProfilerRange& operator=(const ProfilerRange&) = delete;
};

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

// Whether the device has come to it; also where it was never recorded. Does not wait.
inline bool is_over(cudaEvent_t event, const char* what)
{
    const cudaError_t answer = cudaEventQuery(event);
    if (answer == cudaErrorNotReady) {
        cudaGetLastError();  // else the next launch finds it
        return false;
    }
    check(answer, what);
    return true;
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

// Whether a kernel may be started before the one it waits for is over (from sm_90 on).
inline bool supports_pdl()
{
    int device = 0, major = 0;
    check(cudaGetDevice(&device), "device");
    check(cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, device), "device");
    return major >= 9;
}

// The same for a kernel that begins with wait_upstream_and_trigger(): where the device can, its
// thread blocks become resident while the kernel before it on the stream still runs.
template <class... Parameters, class... Arguments>
void launch_pdl(const char* name, void (*kernel)(Parameters...), int blocks, int threads,
                cudaStream_t stream, const Arguments&... arguments)
{
    if (blocks == 0) return;
    const ProfilerRange range{name};
    cudaLaunchAttribute early{};
    early.id = cudaLaunchAttributeProgrammaticStreamSerialization;
    early.val.programmaticStreamSerializationAllowed = 1;
    cudaLaunchConfig_t config{};
    config.gridDim = dim3(unsigned(blocks)), config.blockDim = dim3(unsigned(threads));
    config.stream = stream, config.attrs = &early, config.numAttrs = supports_pdl() ? 1 : 0;
    check(cudaLaunchKernelEx(&config, kernel, arguments...), name);
}

// By every thread of a kernel: lets the next one, if it is launched early, become resident.
__device__ inline void trigger_dependents()
{
    NV_IF_TARGET(NV_PROVIDES_SM_90, (cudaTriggerProgrammaticLaunchCompletion();))
}

// By every thread of a kernel so launched, before it reads what the one before it writes: waits for
// the end of that one.
__device__ inline void wait_upstream()
{
    NV_IF_TARGET(NV_PROVIDES_SM_90, (cudaGridDependencySynchronize();))
}

// The same, and lets the next one become resident.
__device__ inline void wait_upstream_and_trigger()
{
    wait_upstream();
    trigger_dependents();
}

inline int blocks_for(int count, int threads) { return (count + threads - 1) / threads; }

}  // namespace knead::gpu
