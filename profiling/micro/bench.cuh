// What the microbenchmarks share: one way to time and one to be believed.
#pragma once
#include <algorithm>
#include <fstream>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "cuda/device/device_array.cuh"
#include "profiling/micro/table.h"

namespace knead::micro {

using gpu::blocks_for;
using gpu::check;
using gpu::DeviceArray;
using gpu::launch;

constexpr int threads = 128;  // of a block

// Keeps the device busy, so that the host is ahead with its launches when the clock starts.
__global__ void hold_kernel(long long cycles);
// Stands before and after what is run once; instructions.py counts between them.
__global__ void mark_kernel();

class Bench {
  public:
    explicit Bench(const Settings& settings);
    Bench(const Bench&) = delete;
    ~Bench();

    const Settings settings;
    Limits limits;
    cudaStream_t stream = nullptr;
    std::vector<Row> rows;

    // Forms are only counted by a profiler, and run once.
    bool once() const { return !settings.once.empty(); }
    // Whether a question is asked for.
    bool wanted(const std::string& question) const
    {
        return question.find(settings.only) != std::string::npos;
    }
    // Median seconds of `run`, each time after `prepare`, which is not timed.
    double seconds(const std::string& name, const std::function<void()>& prepare,
                   const std::function<void()>& run);
    // Times a form and keeps its row; `right` is asked after the last run.
    void add(Row row, const std::function<void()>& prepare, const std::function<void()>& run,
             const std::function<bool()>& right);

    // Most of these per second, where each takes that many bytes of a copy.
    double by_copy(double bytes) const { return limits.copy / bytes; }

  private:
    std::ofstream names;  // of forms that were run once
};

// A kernel that spills says nothing of its form.
template <class... P>
void must_not_spill(const char* name, void (*kernel)(P...))
{
    cudaFuncAttributes found;
    check(cudaFuncGetAttributes(&found, reinterpret_cast<const void*>(kernel)), name);
    if (found.localSizeBytes > 0)
        throw std::runtime_error(std::string(name) + ": uses local memory");
}

// A number without order, the same for the same x.
__host__ __device__ inline unsigned scrambled(unsigned x)
{
    x = (x ^ x >> 15) * 2654435761u;
    x = (x ^ x >> 13) * 2246822519u;
    return x ^ x >> 16;
}
// One in [0, 1).
__host__ __device__ inline float random(unsigned x)
{
    return float(scrambled(x) >> 8) * (1.0f / 16777216);
}

// The questions, a file each.
void measure_limits(Bench&);
void measure_atomics(Bench&);
void measure_shared(Bench&);
void measure_merge(Bench&);
void measure_order(Bench&);
void measure_transfer(Bench&);
void measure_return(Bench&);
void measure_early(Bench&);
void measure_rebin(Bench&);

}  // namespace knead::micro
