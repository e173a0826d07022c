// Snapshots of a solver in device memory.
#pragma once
#include <memory>

#include "cuda/device/graph.cuh"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/particles.cuh"
#include "cuda/mpm/sliding.h"
#include "cuda/splats/deform.cuh"
#include "host/solver/edits.h"

namespace knead::gpu {

// Memory pool that never returns freed memory to the device: a snapshot before every edit costs no
// allocation.
struct Pool {
    cudaMemPool_t pool = nullptr;
    explicit Pool(int device);
    Pool(const Pool&) = delete;
    ~Pool() { cudaMemPoolDestroy(pool); }
};

// Memory of a pool for work on one stream.
class PoolMemory {
  public:
    PoolMemory(const std::shared_ptr<Pool>& pool, std::size_t bytes, cudaStream_t stream);
    PoolMemory(const PoolMemory&) = delete;
    ~PoolMemory()
    {
        if (first) cudaFreeAsync(first, stream);
    }
    void* data() const { return first; }

  private:
    std::shared_ptr<Pool> pool;
    cudaStream_t stream;
    void* first = nullptr;
};

// A state in device memory: rows and ids of particles, frames at rest of blocks, sliding along
// walls, and the number of completed substeps.
struct StateView {
    Lattice<float> lattice;
    ConstParticleView particles;
    const int* quiet;
    std::size_t quiet_count;  // 0 without sleep
    const Sliding<float>* sliding;
    std::size_t sliding_count;
    const int* done;
};

// A copy of one. Freed in stream order, after the last copy from it.
struct DeviceState {
    Lattice<float> lattice;
    int count = 0;
    std::size_t row_bytes = 0, id_bytes = 0, quiet_bytes = 0, sliding_bytes = 0;
    unsigned char* memory = nullptr;  // the arrays one after another, those of 16-byte words first
    Event used{cudaEventDisableTiming};
    std::shared_ptr<Pool> pool;

    DeviceState(const Lattice<float>& lattice, int count, std::size_t quiet_bytes,
                std::size_t sliding_bytes, std::shared_ptr<Pool> pool, cudaStream_t stream);
    DeviceState(const DeviceState&) = delete;
    ~DeviceState();
    std::size_t bytes() const
    {
        return row_bytes + id_bytes + quiet_bytes + sliding_bytes + sizeof(int);
    }
    unsigned char* rows() const { return memory; }
    StateView view() const
    {
        return {
            lattice,
            {reinterpret_cast<const float4*>(rows()), reinterpret_cast<const int*>(ids()), count},
            reinterpret_cast<const int*>(quiet()),
            quiet_bytes / sizeof(int),
            reinterpret_cast<const Sliding<float>*>(sliding()),
            sliding_bytes / sizeof(Sliding<float>),
            done()};
    }
    unsigned char* sliding() const { return memory + row_bytes; }
    unsigned char* ids() const { return sliding() + sliding_bytes; }
    unsigned char* quiet() const { return ids() + id_bytes; }
    int* done() const { return reinterpret_cast<int*>(quiet() + quiet_bytes); }
};

// Gaussians in the layout of GaussianView; freed likewise.
struct GaussianState {
    int count = 0, room = 0;
    std::size_t bytes = 0;
    unsigned char* memory = nullptr;
    Event used{cudaEventDisableTiming};
    std::shared_ptr<Pool> pool;

    GaussianState() = default;
    GaussianState(int count, int room, std::size_t bytes, std::shared_ptr<Pool> pool,
                  cudaStream_t stream);
    GaussianState(const GaussianState&) = delete;
    ~GaussianState();
    GaussianView view() const { return gaussians_in(memory, count, room); }
};

inline bool same_box(const Lattice<float>& a, const Lattice<float>& b)
{
    return a.low == b.low && a.stored == b.stored;
}

// The complete state of a solver.
struct GpuSnapshot : Snapshot {
    std::shared_ptr<const char> solver;
    std::shared_ptr<const SceneState> rules;
    std::shared_ptr<DeviceState> state;
    std::shared_ptr<GaussianState> splats;
    Peak peak{};       // of Clock
    double drift = 0;  // of Clock
    bool was_covered = false;
    std::size_t bytes() const override { return state ? state->bytes() + splats->bytes : 0; }
};

}  // namespace knead::gpu
