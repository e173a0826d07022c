// Edits of a store between two frames: add, remove and reorder particles.
#include <algorithm>
#include <memory>
#include <mutex>
#include <numeric>

#include "cuda/device/copy.cuh"
#include "cuda/mpm/edit.cuh"
#include "host/base/parallel.h"
#include "host/solver/gpu/store.cuh"

namespace knead::gpu {
namespace {

void copy(void* to, const void* from, std::size_t bytes, cudaStream_t stream)
{
    if (bytes) check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDefault, stream), "edit");
}

// Particles in the device's row layout, in parallel.
std::vector<float4> rows_of(const std::vector<Particle<double>>& particles,
                            const std::vector<int>& order)
{
    std::vector<float4> rows(particle_rows * order.size());
    const ParticleView view{rows.data(), nullptr, int(order.size())};
    parallel_for(view.count, [&](int i) {
        view.store(i, cast<float>(particles[std::size_t(order[std::size_t(i)])]));
    });
    return rows;
}

// New particles in the device's row layout and their bounding box, computed in parallel to keep
// edits short in VR.
struct Fresh {
    std::unique_ptr<float4[]> rows;
    Box3<float> box = empty_box<float>();
};
Fresh fresh_of(Clays clays, const std::vector<int>& objects, std::size_t count)
{
    Fresh made{std::make_unique_for_overwrite<float4[]>(particle_rows * count)};
    const ParticleView view{made.rows.get(), nullptr, int(count)};
    const std::vector<AddedPiece> pieces = pieces_of(clays);
    const int all = int(pieces.size());
    std::mutex taking;
    parallel_for(all, LoopOptions{.chunk = 1}, [&](int k) {
        Fresh own{};
        const AddedPiece& piece = pieces[std::size_t(k)];
        int i = int(piece.first);
        for (Particle<double> p : piece.of) {
            p.object = objects[piece.clay];
            const Particle<float> q = cast<float>(p);
            view.store(i++, q), grow(own.box, q.x);
        }
        const std::lock_guard<std::mutex> lock(taking);
        grow(made.box, own.box);
    });
    return made;
}

}  // namespace

void Store::set_count(int count)
{
    const auto n = std::size_t(count), all_rows = particle_rows * n;
    const std::size_t other = rows.size() < 2 * all_rows ? n : all_rows;
    all.particles[0] = {rows.data(), ids[0].data(), count};
    all.particles[1] = {rows.data() + other, ids[1].data(), count};
    reserve_runs();
}

// Allocates the lists of runs for the current particle count and run length.
void Store::reserve_runs()
{
    all.rest.run = run_length(used);
    const auto run_count = std::size_t(blocks_for(count(), all.rest.run));
    if (used.rests) reserve(run_listed, run_count), reserve(runs, run_count);
    if (used.tools) {
        std::vector<int> every(run_count);
        std::iota(every.begin(), every.end(), 0);
        reserve(near_runs, run_count);
        reserve(in_line, run_count);
        copy(in_line.data(), every.data(), run_count * sizeof(int), nullptr);
        settle("runs");
    }
    all.rest.run_listed = run_listed.data(), all.rest.list = runs.data();
    all.tools.runs = in_line.data(), all.tools.near_runs = near_runs.data();
    all.tools.run_count = used.tools ? int(run_count) : 0;
}

void Store::reserve_scratch(int count)
{
    if (count == 0) return;
    const Lattice<float> whole{all.lattice.size, all.lattice.dx};
    const std::size_t bytes =
        std::max(sort_scratch_bytes(count, whole, used), keep_scratch_bytes(count));
    if (scratch.size() < bytes) scratch = DeviceArray<unsigned char>(bytes);
}

void Store::resize(int count)
{
    const auto n = std::size_t(count);
    reserve_scratch(count);
    const auto larger = [](const auto& array, std::size_t wanted) {
        using Array = std::remove_cvref_t<decltype(array)>;
        return array.size() < wanted ? Array(wanted) : Array();
    };
    auto all_rows = larger(rows, row_places(n));
    auto one = larger(ids[0], n), other = larger(ids[1], n);
    if (all_rows.size() > 0) rows = std::move(all_rows);
    if (one.size() > 0) ids[0] = std::move(one);
    if (other.size() > 0) ids[1] = std::move(other);
    set_count(count);
}

void Store::put(const ClayRows& clay, cudaStream_t stream) const
{
    static_assert(plane_words == clay_planes + 2);
    const std::size_t n = clay.count;
    // Rows 4 to 6 are free on side 0 (row_places()), and as large as the planes.
    float* const planes = reinterpret_cast<float*>(rows.data() + 4 * n);
    copy(planes, clay.planes.data(), clay_planes * n * sizeof(float), stream);
    copy(planes + clay_planes * n, clay.object.data(), n * sizeof(int), stream);
    copy(planes + (clay_planes + 1) * n, clay.sides.data(), n * sizeof(unsigned), stream);
    from_planes(planes, all.particles[0], stream);
}

// Performs all allocations that may fail before particles are written to the other rows. Both sets
// of rows have the same capacity, so that a snapshot always fits.
void Store::reserve_others(std::size_t n)
{
    reserve_scratch(int(n));
    const auto as_many = [](auto& array, std::size_t wanted, std::size_t there) {
        if (wanted > there)
            reserve(array, wanted);
        else if (array.size() < there)
            array = std::remove_reference_t<decltype(array)>(there);
    };
    as_many(other_rows, row_places(n), rows.size());
    as_many(other_ids, n, ids[0].size());
}

// Makes the other rows current.
void Store::swap_in(int count)
{
    reserve(ids[1], std::size_t(count));
    std::swap(rows, other_rows), std::swap(ids[0], other_ids);
    set_count(count);
}

void Store::upload(const std::vector<Particle<double>>& particles, const std::vector<int>& order)
{
    const std::vector<float4> host = rows_of(particles, order);
    copy(all.particles[0].rows, host.data(), host.size() * sizeof host[0], nullptr);
    copy(ids[0].data(), order.data(), order.size() * sizeof order[0], nullptr);
    settle("upload");
}

void Store::append(Clays clays, const std::vector<int>& objects, int side, cudaStream_t stream)
{
    std::size_t more = 0;
    for (const auto& clay : clays) more += clay.size();
    const auto before = std::size_t(count()), n = before + more;
    const Fresh fresh = fresh_of(clays, objects, more);
    hold(fresh.box);
    std::vector<int> order(more);
    std::iota(order.begin(), order.end(), int(before));
    reserve_others(n);
    copy(other_ids.data() + before, order.data(), more * sizeof(int), stream);
    std::vector<CopiedRange> ranges{
        {other_ids.data(), all.particles[side].ids, before * sizeof(int)}};
    for (std::size_t r = 0; r < particle_rows; ++r) {
        float4* const row = other_rows.data() + r * n;
        ranges.push_back({row, all.particles[side].rows + r * before, before * sizeof(float4)});
        copy(row + before, fresh.rows.get() + r * more, more * sizeof(float4), stream);
    }
    gpu::copy("add", ranges, stream);
    wait(stream, "add");
    swap_in(int(n));
}

void Store::erase(const std::vector<char>& objects, long left, int side, cudaStream_t stream)
{
    const auto n = std::size_t(left);
    reserve_others(n);
    reserve_scratch(count());
    reserve(places, 2 * std::size_t(count())), reserve(gone, objects.size());
    copy(gone.data(), objects.data(), objects.size(), stream);
    const ParticleView to{other_rows.data(), other_ids.data(), int(left)};
    keep_others(all.particles[side], gone.data(), to, places.data(), scratch.data(),
                scratch.bytes(), stream);
    wait(stream, "remove");
    swap_in(int(left));
}

// Restores the order and box of a new store: in fixed point the partial sums of warps depend on
// both.
void Store::arrange_as_new(const Extent& around, int side, cudaStream_t stream)
{
    const auto n = std::size_t(count());
    reserve_others(n);
    order_by_id(all.particles[side], {other_rows.data(), other_ids.data(), count()}, stream);
    wait(stream, "order by id");
    swap_in(int(n));
    enclose({around.lowest(), around.highest()});
}

Extent Store::extent(int object, const RigidMotion<double>& motion, int side,
                     cudaStream_t stream) const
{
    const Extent none;
    copy(found.data(), &none, sizeof none, stream);
    gpu::extent(all.particles[side], all.materials, object, motion, found.data(), stream);
    wait(stream, "extent");
    return found.downloaded()[0];
}

void Store::slide_on(const std::vector<SlidingNode>& nodes, int done) const
{
    std::vector<Sliding<float>> each(sliding.size());
    for (const SlidingNode& n : nodes)
        each[std::size_t(n.place)] = {n.force, n.time, done - 1, n.impulse_deficit};
    gpu::upload(sliding.data(), each.data(), each.size());
}

void Store::forget_sliding(cudaStream_t stream) const
{
    if (sliding.size() == 0) return;
    gpu::check(cudaMemsetAsync(sliding.data(), 0, sliding.bytes(), stream), "forget sliding");
}

void Store::set_quiet(const std::vector<int>& quiet) const
{
    if (!used.rests) return;
    copy(box.quiet.data(), quiet.data(), quiet.size() * sizeof quiet[0], nullptr);
    settle("quiet blocks");
}

void Store::forget_quiet(cudaStream_t stream) const
{
    if (!used.rests) return;
    gpu::check(cudaMemsetAsync(box.quiet.data(), 0, box.quiet.bytes(), stream), "quiet blocks");
}

std::shared_ptr<DeviceState> Store::state(int side, cudaStream_t stream) const
{
    auto to = std::make_shared<DeviceState>(
        all.lattice, count(), used.rests ? box.quiet.bytes() : 0, sliding.bytes(), pool, stream);
    const CopiedRange ranges[] = {{to->rows(), all.particles[side].rows, to->row_bytes},
                                  {to->sliding(), sliding.data(), to->sliding_bytes},
                                  {to->ids(), all.particles[side].ids, to->id_bytes},
                                  {to->quiet(), box.quiet.data(), to->quiet_bytes},
                                  {to->done(), &all.clock->done, sizeof(int)}};
    gpu::copy("snapshot", ranges, stream);
    gpu::check(cudaEventRecord(to->used, stream), "snapshot");
    return to;
}

StateView Store::state_view(int side) const
{
    return {all.lattice,      read_only(all.particles[side]),
            box.quiet.data(), box.quiet.size(),
            sliding.data(),   sliding.size(),
            &all.clock->done};
}

void Store::put_back(const DeviceState& from, int side, cudaStream_t stream) const
{
    const CopiedRange ranges[] = {
        {all.particles[side].rows, from.rows(), from.row_bytes},
        {sliding.data(), from.sliding(), from.sliding_bytes},
        {all.particles[side].ids, from.ids(), from.id_bytes},
        {box.quiet.data(), from.quiet(), used.rests ? from.quiet_bytes : 0}};
    gpu::copy("restore", ranges, stream);
    gpu::slide_on(sliding.data(), int(sliding.size()), from.done(), all.clock, stream);
    gpu::check(cudaEventRecord(from.used, stream), "restore");
}

Pool::Pool(int device)
{
    cudaMemPoolProps properties{};
    properties.allocType = cudaMemAllocationTypePinned;
    properties.location = {cudaMemLocationTypeDevice, device};
    check(cudaMemPoolCreate(&pool, &properties), "snapshot memory");
    std::uint64_t keep = ~std::uint64_t(0);
    check(cudaMemPoolSetAttribute(pool, cudaMemPoolAttrReleaseThreshold, &keep), "snapshot memory");
}

PoolMemory::PoolMemory(const std::shared_ptr<Pool>& from, std::size_t bytes, cudaStream_t of)
    : pool(from), stream(of)
{
    if (bytes) check(cudaMallocFromPoolAsync(&first, bytes, pool->pool, stream), "snapshot memory");
}

DeviceState::DeviceState(const Lattice<float>& of, int particles, std::size_t quiet,
                         std::size_t sliding, std::shared_ptr<Pool> from, cudaStream_t stream)
    : lattice(of),
      count(particles),
      row_bytes(std::size_t(particles) * particle_rows * sizeof(float4)),
      id_bytes(std::size_t(particles) * sizeof(int)),
      quiet_bytes(quiet),
      sliding_bytes(sliding),
      pool(std::move(from))
{
    void* all = nullptr;
    check(cudaMallocFromPoolAsync(&all, bytes(), pool->pool, stream), "snapshot memory");
    memory = static_cast<unsigned char*>(all);
}

DeviceState::~DeviceState()
{
    if (!memory) return;
    cudaStreamWaitEvent(nullptr, used);
    cudaFreeAsync(memory, nullptr);
}

}  // namespace knead::gpu
