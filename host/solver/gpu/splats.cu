#include <algorithm>
#include <cstring>
#include <numeric>

#include "cuda/mpm/stencil.h"
#include "host/base/parallel.h"
#include "host/solver/gpu/splats.cuh"

namespace knead::gpu {
namespace {

template <class R>
Gaussian<R> loaded(const GaussianView& host, int i)
{
    Gaussian<float> g = host.load(i);
    g.object = host.objects[i], g.sides = host.sides[i];
    return cast<R>(g);
}

void download(std::vector<unsigned char>& to, const void* from, cudaStream_t stream)
{
    check(cudaMemcpyAsync(to.data(), from, to.size(), cudaMemcpyDefault, stream), "Gaussians");
    check(cudaStreamSynchronize(stream), "Gaussians");
}

// Indices in ascending order of their keys, equal ones in their own order: a radix sort.
std::vector<int> order_by(const std::vector<int>& keys)
{
    constexpr unsigned digit_bits = 11, digits = 1u << digit_bits;
    std::vector<int> order(keys.size()), next(keys.size());
    std::iota(order.begin(), order.end(), 0);
    if (keys.empty()) return order;
    const auto [low, high] = std::minmax_element(keys.begin(), keys.end());
    const unsigned first = unsigned(*low), range = unsigned(*high) - first;
    for (unsigned shift = 0; shift < 32 && range >> shift; shift += digit_bits) {
        const auto digit = [&](int i) {
            return (unsigned(keys[std::size_t(i)]) - first) >> shift & (digits - 1);
        };
        std::vector<std::size_t> at(digits + 1, 0);
        for (const int i : order) ++at[digit(i) + 1];
        std::partial_sum(at.begin(), at.end(), at.begin());
        for (const int i : order) next[at[digit(i)]++] = i;
        std::swap(order, next);
    }
    return order;
}

// Grows an array with a quarter of spare capacity. Contents are lost.
template <class T>
void hold(DeviceArray<T>& array, std::size_t count)
{
    if (array.size() < count) array = DeviceArray<T>(count + count / 4);
}

}  // namespace

// Grows the memory to the given capacity. Contents are lost.
void Splats::reserve(int count, int room)
{
    const std::size_t bytes = std::size_t(room) * GaussianView::bytes_each;
    if (memory.size() < bytes) memory = DeviceArray<unsigned char>(bytes);
    view_ = gaussians_in(memory.data(), count, room, live.data());
}

void Splats::set_count(int count, cudaStream_t stream)
{
    view_.count = count;
    check(cudaMemcpyAsync(live.data(), &count, sizeof count, cudaMemcpyDefault, stream),
          "Gaussians");
}

// Grows the capacity by a quarter beyond `count` if needed; keeps the Gaussians and their places.
void Splats::make_room(int count, cudaStream_t stream)
{
    if (count <= view_.room) return;
    const GaussianView from = view_;
    const DeviceArray<unsigned char> before = std::move(memory);
    memory = {};
    reserve(from.count, count + count / 4);
    const auto copy = [&](auto* to, const auto* of, int rows) {
        const std::size_t each = sizeof *to;
        check(cudaMemcpy2DAsync(to, std::size_t(view_.room) * each, of,
                                std::size_t(from.room) * each, std::size_t(from.count) * each,
                                std::size_t(rows), cudaMemcpyDeviceToDevice, stream),
              "Gaussians");
    };
    if (from.count > 0) {
        copy(view_.rows, from.rows, gaussian_rows);
        copy(view_.sides, from.sides, 3);  // sides, and the two arrays that follow it
    }
    wait(stream, "Gaussians");
}

// Swaps between two allocations that are both kept: freeing one would synchronise the device.
void Splats::erase(const std::vector<char>& objects, cudaStream_t stream)
{
    if (count() == 0) return;
    const int n = count() + 1;
    hold(gone, objects.size()), hold(places, 2 * std::size_t(n)), hold(sums, keep_scratch_bytes(n));
    const auto copy = [stream](void* to, const void* from, std::size_t bytes) {
        check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDefault, stream), "Gaussians");
    };
    copy(gone.data(), objects.data(), objects.size());
    choose(view_, gone.data(), places.data(), sums.data(), sums.size(), stream);
    int kept = 0;
    copy(&kept, places.data() + count(), sizeof kept);
    wait(stream, "Gaussians");
    if (kept == count()) return;
    if (other.size() < memory.size()) other = DeviceArray<unsigned char>(memory.size());
    const GaussianView to = gaussians_in(other.data(), kept, view_.room, live.data());
    copy_chosen(view_, gone.data(), to, places.data(), stream);
    set_count(kept, stream);
    std::swap(memory, other), view_ = to;
}

bool Splats::edit(const GaussianEdits& edits, const ParticleView& particles,
                  const WallOptions& walls, cudaStream_t stream)
{
    const int split = int(edits.splits.size()), beside = int(edits.added.size());
    const GaussianView before = view_;
    const int places_told = int(edits.placed.size());
    make_room(count() + split + beside + places_told, stream);
    const auto given = [&](auto& to, const auto& from) {
        using Array = std::remove_reference_t<decltype(to)>;
        if (to.size() < from.size()) to = Array(2 * from.size());
        check(cudaMemcpyAsync(to.data(), from.data(), from.size() * sizeof from[0],
                              cudaMemcpyDefault, stream),
              "Gaussians");
    };
    hold(places, std::size_t(std::max(count(), particles.count)));
    if (split > 0) {
        given(splits, edits.splits);
        gpu::split(view_, splits.data(), split, places.data(), walls, stream);
        view_.count += split;
    }
    if (beside > 0) {
        given(added, edits.added);
        add_beside(view_, particles, added.data(), beside, places.data(), walls, stream);
        view_.count += beside;
    }
    if (places_told > 0) {
        given(placed, edits.placed);
        place(view_, placed.data(), places_told, stream);
        view_.count += places_told;
    }
    set_count(view_.count, stream);
    return view_.rows != before.rows || view_.room != before.room;
}

template <class R>
void Splats::set(const std::vector<Gaussian<R>>& all, const Lattice<float>& lattice)
{
    std::vector<int> nodes(all.size());  // base nodes
    parallel_for(all.size(), [&](std::size_t i) {
        nodes[i] = lattice.index(base_node(cast<float>(all[i].x), lattice.spacing));
    });
    const std::vector<int> order = order_by(nodes);
    const int room = std::max(int(all.size()), view_.room);  // keep the capacity: a graph may have
                                                             // captured it
    std::vector<unsigned char> host(std::size_t(room) * GaussianView::bytes_each);
    const GaussianView to = gaussians_in(host.data(), int(all.size()), room);
    parallel_for(to.count, [&](int i) {
        to.ids[i] = order[std::size_t(i)];
        const Gaussian<R>& g = all[std::size_t(to.ids[i])];
        to.store(i, cast<float>(g));
        to.sides[i] = g.label(), to.objects[i] = g.object;
    });
    reserve(to.count, room);
    upload(memory.data(), host.data(), host.size());
    upload(live.data(), &to.count, 1);
}
template void Splats::set(const std::vector<Gaussian<float>>&, const Lattice<float>&);
template void Splats::set(const std::vector<Gaussian<double>>&, const Lattice<float>&);

std::vector<Gaussian<double>> Splats::all() const
{
    return downloaded<double>(memory.data(), count(), view_.room, nullptr);
}

SomeGaussians some_of(const GaussianState& state, std::span<const int> objects, cudaStream_t stream)
{
    SomeGaussians some;
    if (state.count == 0 || objects.empty()) return some;
    std::vector<char> wanted(std::size_t(*std::max_element(objects.begin(), objects.end())) + 1, 0);
    for (const int object : objects) wanted[std::size_t(object)] = 1;
    std::vector<unsigned char> host(state.bytes);
    download(host, state.memory, stream);
    const GaussianView there = gaussians_in(host.data(), state.count, state.room);
    const auto chosen = [&](int place) {
        const auto object = std::size_t(there.objects[place]);
        return object < wanted.size() && wanted[object];
    };
    // In the order of attachment.
    std::vector<int> place_of(static_cast<std::size_t>(state.count), -1);
    for (int i = 0; i < state.count; ++i)
        if (chosen(i)) place_of[std::size_t(there.ids[i])] = i;
    for (std::size_t id = 0; id < place_of.size(); ++id)
        if (place_of[id] >= 0) some.indices.push_back(int(id));
    some.gaussians.resize(some.indices.size());
    const int count = int(some.indices.size());
    for (int k = 0; k < count; ++k) {
        const auto id = std::size_t(some.indices[std::size_t(k)]);
        some.gaussians[std::size_t(k)] = loaded<double>(there, place_of[id]);
    }
    return some;
}

template <class R>
std::vector<Gaussian<R>> downloaded(const void* memory, int count, int room, cudaStream_t stream)
{
    std::vector<Gaussian<R>> to(static_cast<std::size_t>(count));
    if (count == 0) return to;
    std::vector<unsigned char> host(std::size_t(room) * GaussianView::bytes_each);
    download(host, memory, stream);
    const GaussianView there = gaussians_in(host.data(), count, room);
    for (int i = 0; i < count; ++i) to[std::size_t(there.ids[i])] = loaded<R>(there, i);
    return to;
}
template std::vector<Gaussian<float>> downloaded(const void*, int, int, cudaStream_t);
template std::vector<Gaussian<double>> downloaded(const void*, int, int, cudaStream_t);

void Splats::show(cudaStream_t stream)
{
    const std::size_t floats = std::size_t(count()) * MovedGaussians::floats_each;
    if (drawn.size() < floats) {
        wait(stream, "Gaussians");  // a renderer may still read the smaller one
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
    if (view_.room == 0) return none;
    auto to = std::make_shared<GaussianState>(count(), view_.room,
                                              std::size_t(view_.room) * GaussianView::bytes_each,
                                              std::move(pool), stream);
    check(cudaMemcpyAsync(to->memory, memory.data(), to->bytes, cudaMemcpyDefault, stream),
          "snapshot");
    check(cudaEventRecord(to->used, stream), "snapshot");
    return to;
}

void Splats::put_back(const GaussianState& from, cudaStream_t stream)
{
    reserve(from.count, from.room);
    set_count(from.count, stream);
    copy_back(from, stream);
}

void Splats::copy_back(const GaussianState& from, cudaStream_t stream) const
{
    if (from.bytes == 0) return;
    check(cudaMemcpyAsync(memory.data(), from.memory, from.bytes, cudaMemcpyDefault, stream),
          "restore");
    check(cudaEventRecord(from.used, stream), "restore");
}

GaussianState::GaussianState(int gaussians, int places, std::size_t size,
                             std::shared_ptr<Pool> from, cudaStream_t stream)
    : count(gaussians), room(places), bytes(size), pool(std::move(from))
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
