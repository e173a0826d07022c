#include "host/bench/device.h"

#include <algorithm>
#include <memory>
#include <stdexcept>

#include "host/base/machine.h"
#include "host/base/parallel.h"
#include "host/scene/seed.h"

namespace knead {
namespace {

// Copy rate [bytes/s], as in STREAM: each thread copies its own section of memory that it touched
// first; arrays far larger than the caches; best of several passes.
double copy_on_cpu(int threads)
{
    const long count = long(std::min<std::size_t>(32 << 20, available_memory() / 64));
    const std::unique_ptr<double[]> from(new double[std::size_t(count)]),
        to(new double[std::size_t(count)]);
    double best = 0;
    for (int pass = 0; pass < 8; ++pass) {
        const double start = wall_seconds();
        parallel_for(count, LoopOptions{.threads = threads}, [&](long i) {
            if (pass == 0) from[i] = double(i);
            to[i] = from[i];
        });
        const double time = wall_seconds() - start;
        if (pass > 0) best = std::max(best, 2 * sizeof(double) * double(count) / time);
    }
    const long middle = count / 2;
    if (to[middle] != double(middle)) throw std::runtime_error("the copy went wrong");
    return best;
}

}  // namespace

DeviceInfo device_facts(Device device, int threads)
{
    if (device.kind == DeviceKind::cuda) return gpu::facts_of(device.index);
    DeviceInfo facts;
    facts.name = cpu_name();
    facts.memory = total_memory();
    facts.copy = copy_on_cpu(threads);
    return facts;
}

std::size_t free_memory(Device device)
{
    return device.kind == DeviceKind::cuda ? gpu::free_memory(device.index) : available_memory();
}

#ifndef KNEAD_HAS_CUDA
namespace gpu {
DeviceInfo facts_of(int) { throw std::runtime_error("this build has no CUDA side"); }
std::size_t free_memory(int) { throw std::runtime_error("this build has no CUDA side"); }
}  // namespace gpu
#endif

}  // namespace knead
