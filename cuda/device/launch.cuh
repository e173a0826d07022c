// The only place where kernels are launched: named for the profiler, checked for errors.
#pragma once
#include <cuda_runtime.h>

#include <atomic>
#include <nv/target>
#include <stdexcept>
#include <string>

namespace knead::gpu {

// A profiler range of the domain "knead" on the calling thread, for the object's lifetime.
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

// Every wait of the host for the device goes through this function and is counted.
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

// Whether the device has passed the event; true if it was never recorded. Does not wait.
inline bool is_over(cudaEvent_t event, const char* what)
{
    const cudaError_t answer = cudaEventQuery(event);
    if (answer == cudaErrorNotReady) {
        cudaGetLastError();  // else the next launch reports it
        return false;
    }
    check(answer, what);
    return true;
}

// `name` is the profiler range and the error text. Does nothing for 0 blocks.
template <class... Parameters, class... Arguments>
void launch(const char* name, void (*kernel)(Parameters...), int blocks, int threads,
            cudaStream_t stream, const Arguments&... arguments)
{
    if (blocks == 0) return;
    const ProfilerRange range{name};
    kernel<<<unsigned(blocks), unsigned(threads), 0, stream>>>(arguments...);
    check(cudaGetLastError(), name);
}

// Whether programmatic dependent launch is supported (sm_90 and later).
inline bool supports_pdl()
{
    int device = 0, major = 0;
    check(cudaGetDevice(&device), "device");
    check(cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, device), "device");
    return major >= 9;
}

// The same for a kernel that begins with wait_upstream_and_trigger(): where supported, its thread
// blocks become resident while the kernel before it on the stream still runs.
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

// Call from every thread of a kernel: the next kernel, if launched early, may become resident.
__device__ inline void trigger_dependents()
{
    NV_IF_TARGET(NV_PROVIDES_SM_90, (cudaTriggerProgrammaticLaunchCompletion();))
}

// Call from every thread of a kernel launched this way, before it reads data written by the
// previous kernel on the stream: waits for the end of that kernel.
__device__ inline void wait_upstream()
{
    NV_IF_TARGET(NV_PROVIDES_SM_90, (cudaGridDependencySynchronize();))
}

// wait_upstream(), then trigger_dependents().
__device__ inline void wait_upstream_and_trigger()
{
    wait_upstream();
    trigger_dependents();
}

inline int blocks_for(int count, int threads) { return (count + threads - 1) / threads; }

}  // namespace knead::gpu
