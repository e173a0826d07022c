#include <algorithm>
#include <cstring>
#include <numeric>

#include "cuda/mpm/stencil.h"
#include "host/solver/gpu/splats.cuh"

namespace knead::gpu {

// Room for so many, and a quarter more where it has to grow; what was there is lost.
void Splats::reserve(int count)
{
    const std::size_t bytes = std::size_t(count) * GaussianView::bytes_each;
    if (memory.size() < bytes) memory = DeviceArray<unsigned char>(bytes + bytes / 4);
    view_ = gaussians_in(memory.data(), count);
}

void Splats::set(const std::vector<Gaussian<double>>& all, const Lattice<float>& lattice)
{
    std::vector<std::pair<int, int>> order;  // index of the lowest node, place
    for (std::size_t i = 0; i < all.size(); ++i)
        order.emplace_back(lattice.index(base_node(cast<float>(all[i].x), lattice.spacing)),
                           int(i));
    std::sort(order.begin(), order.end());
    std::vector<unsigned char> host(all.size() * GaussianView::bytes_each);
    const GaussianView to = gaussians_in(host.data(), int(all.size()));
    for (int i = 0; i < to.count; ++i) {
        to.ids[i] = order[std::size_t(i)].second;
        const Gaussian<double>& g = all[std::size_t(to.ids[i])];
        to.store(i, cast<float>(g));
        to.sides[i] = g.label(), to.objects[i] = g.object;
    }
    reserve(to.count);
    upload(memory.data(), host.data(), host.size());
}

std::vector<Gaussian<double>> Splats::all() const
{
    const auto n = std::size_t(count());
    std::vector<unsigned char> host(n * GaussianView::bytes_each);
    std::vector<Gaussian<double>> to(n);
    if (host.empty()) return to;
    check(cudaMemcpy(host.data(), memory.data(), host.size(), cudaMemcpyDefault), "Gaussians");
    const GaussianView from = gaussians_in(host.data(), count());
    for (int i = 0; i < from.count; ++i) {
        Gaussian<double>& g = to[std::size_t(from.ids[i])] = cast<double>(from.load(i));
        g.object = from.objects[i], g.sides = from.sides[i];
    }
    return to;
}

void Splats::show(cudaStream_t stream)
{
    const std::size_t floats = std::size_t(count()) * MovedGaussians::floats_each;
    if (drawn.size() < floats) {
        wait(stream, "Gaussians");  // who draws may still read the smaller one
        drawn = DeviceArray<float>(floats + floats / 4);
    }
    moved_ = {drawn.data(), count(), stream};
    arrange(view_, drawn.data(), stream);
}

Extent Splats::extent(int object, const RigidMotion<double>& motion, cudaStream_t stream) const
{
    if (count() == 0) return {};
    const DeviceArray<Extent> found(std::vector<Extent>(1));
    gpu::extent(view_, object, motion, found.data(), stream);
    wait(stream, "extent of splats");
    return found.downloaded()[0];
}

std::shared_ptr<GaussianState> Splats::state(std::shared_ptr<Pool> pool, cudaStream_t stream) const
{
    auto to = std::make_shared<GaussianState>(
        count(), std::size_t(count()) * GaussianView::bytes_each, std::move(pool), stream);
    if (to->bytes)
        check(cudaMemcpyAsync(to->memory, memory.data(), to->bytes, cudaMemcpyDefault, stream),
              "snapshot");
    check(cudaEventRecord(to->used, stream), "snapshot");
    return to;
}

void Splats::put_back(const GaussianState& from, cudaStream_t stream)
{
    reserve(from.count);
    copy_back(from, stream);
}

void Splats::copy_back(const GaussianState& from, cudaStream_t stream) const
{
    if (from.bytes)
        check(cudaMemcpyAsync(memory.data(), from.memory, from.bytes, cudaMemcpyDefault, stream),
              "restore");
    check(cudaEventRecord(from.used, stream), "restore");
}

GaussianState::GaussianState(int gaussians, std::size_t size, std::shared_ptr<Pool> from,
                             cudaStream_t stream)
    : count(gaussians), bytes(size), pool(std::move(from))
{
    if (bytes == 0) return;
    void* all = nullptr;
    check(cudaMallocFromPoolAsync(&all, bytes, pool->pool, stream), "snapshot memory");
    memory = static_cast<unsigned char*>(all);
}

GaussianState::~GaussianState()
{
    if (!memory) return;
    cudaStreamWaitEvent(nullptr, used);
    cudaFreeAsync(memory, nullptr);
}

}  // namespace knead::gpu
