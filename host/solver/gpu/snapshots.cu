// Snapshots of the GPU solver, and what is read from them. Reading uses a stream of its own: it may
// run in any thread while frames are computed.
#include <algorithm>
#include <stdexcept>

#include "host/solver/gpu/solver.cuh"

namespace knead::gpu {
namespace {

template <class T>
void download(std::vector<T>& to, const void* from, cudaStream_t stream)
{
    if (to.empty()) return;
    check(cudaMemcpyAsync(to.data(), from, to.size() * sizeof(T), cudaMemcpyDefault, stream),
          "snapshot");
    check(cudaStreamSynchronize(stream), "snapshot");
}

template <class T>
std::vector<T> downloaded(const T* from, std::size_t count, cudaStream_t stream)
{
    std::vector<T> to(count);
    download(to, from, stream);
    return to;
}

// By id, not held.
std::vector<Particle<double>> particles_in(const ConstParticleView& from, std::vector<int>& ids,
                                           cudaStream_t stream)
{
    const auto n = std::size_t(from.count);
    ids = downloaded(from.ids, n, stream);
    std::vector<float4> rows = downloaded(from.rows, particle_rows * n, stream);
    return in_double({rows.data(), ids.data(), from.count});
}

// In the order of attachment, not held.
template <class R>
std::vector<Gaussian<R>> attached(const GaussianView& from, cudaStream_t stream)
{
    std::vector<Gaussian<R>> all = gpu::downloaded<R>(from.rows, from.count, from.room, stream);
    for (Gaussian<R>& g : all) g.hold(false);
    return all;
}

// Nodes whose clay slid in the last of `done` substeps.
std::vector<SlidingNode> sliding_nodes(const std::vector<Sliding<float>>& each, int done)
{
    std::vector<SlidingNode> nodes;
    for (std::size_t i = 0; i < each.size(); ++i)
        if (each[i].substep == done - 1)
            nodes.push_back({int(i), each[i].force, each[i].time, each[i].impulse_deficit});
    return nodes;
}

// A state but for what the host keeps of it: configuration, peak, drift, `covered`.
SavedState read(const StateView& from, const GaussianView& splats, cudaStream_t stream)
{
    SavedState to;
    to.contents = {particles_in(from.particles, to.order, stream),
                   attached<double>(splats, stream)};
    to.quiet_low = from.lattice.low, to.quiet_stored = from.lattice.stored;
    to.quiet = downloaded(from.quiet, from.quiet_count, stream);
    to.sliding = sliding_nodes(downloaded(from.sliding, from.sliding_count, stream),
                               downloaded(from.done, 1, stream)[0]);
    return to;
}

}  // namespace

std::shared_ptr<const Snapshot> GpuSolver::snapshot() const
{
    check_idle();
    auto to = std::make_shared<GpuSnapshot>();
    to->solver = identity, to->rules = book;
    to->state = store.state(side, main);
    to->splats = splats.state(store.snapshot_pool(), main);
    to->peak = peak, to->drift = drift, to->was_covered = was_covered;
    return to;
}

const GpuSnapshot& GpuSolver::known(const Snapshot& snapshot) const
{
    const auto* of = dynamic_cast<const GpuSnapshot*>(&snapshot);
    if (!of || of->solver != identity)
        throw std::invalid_argument("the snapshot is of another solver");
    return *of;
}

// Waits until the snapshot is written.
const GpuSnapshot& GpuSolver::complete(const Snapshot& snapshot) const
{
    const GpuSnapshot& from = known(snapshot);
    check(cudaSetDevice(device), "device");
    wait(from.state->used, "snapshot");
    wait(from.splats->used, "snapshot");
    return from;
}

SnapshotData GpuSolver::held(const Snapshot& snapshot) const
{
    const GpuSnapshot& from = complete(snapshot);
    std::vector<int> ids;
    SnapshotData data{particles_in(from.state->view().particles, ids, reading), {}};
    data.gaussians = attached<double>(from.splats->view(), reading);
    return data;
}

// The device arranges the particles by id: on the host that would take longer than the copy.
ClayRows GpuSolver::rows(const Snapshot& snapshot) const
{
    const GpuSnapshot& from = complete(snapshot);
    const auto n = std::size_t(from.state->count);
    ClayRows to = empty_rows(n);
    const PoolMemory planes(store.snapshot_pool(), plane_words * n * sizeof(float), reading);
    const auto* const first = static_cast<const float*>(planes.data());
    to_planes(from.state->view().particles, static_cast<float*>(planes.data()), reading);
    download(to.planes, first, reading);
    download(to.object, first + clay_planes * n, reading);
    download(to.sides, first + (clay_planes + 1) * n, reading);
    to.gaussians = attached<float>(from.splats->view(), reading);
    return to;
}

SomeGaussians GpuSolver::gaussians_of(const Snapshot& snapshot, std::span<const int> objects) const
{
    return some_of(*complete(snapshot).splats, objects, reading);
}

SavedState GpuSolver::saved(const Snapshot& snapshot) const
{
    const GpuSnapshot& from = complete(snapshot);
    SavedState to = read(from.state->view(), from.splats->view(), reading);
    to.config = from.rules->config();
    to.drift = from.drift, to.covered = from.was_covered;
    to.speed_squared = std::bit_cast<float>(from.peak.fastest);
    to.stiffness = std::bit_cast<float>(from.peak.stiffest);
    return to;
}

// Not of a snapshot: a large scene may leave no memory for one.
SavedState GpuSolver::save() const
{
    check_idle();
    wait(main, "save");
    SavedState to = read(store.state_view(side), splats.view(), main);
    to.config = config();
    to.drift = drift, to.covered = was_covered;
    to.speed_squared = std::bit_cast<float>(peak.fastest);
    to.stiffness = std::bit_cast<float>(peak.stiffest);
    return to;
}

// Fills the pool, which keeps what is freed. Later, a snapshot is an allocation from the pool, a
// launch that copies the clay and an event; with Gaussians, another of each.
void GpuSolver::reserve_snapshots(int count)
{
    std::vector<std::shared_ptr<const Snapshot>> all;
    for (int k = 0; k <= count; ++k) all.push_back(snapshot());  // one as scratch of rows()
    all.clear();
    settle("snapshot memory");
}

}  // namespace knead::gpu
