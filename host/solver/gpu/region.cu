// The stored box of nodes (stored_region.h): its arrays, its growth, and the continuation of a
// frame that stopped because clay reached the end of the box.
#include <algorithm>
#include <memory>
#include <string>
#include <utility>

#include "host/solver/gpu/solver.cuh"

namespace knead::gpu {

NodeArrays::NodeArrays(const Lattice<float>& lattice, const Features& features)
{
    const auto blocks = std::size_t(lattice.block_count()),
               grid_nodes = std::size_t(lattice.node_count()) * std::size_t(field_count(features));
    for (int side = 0; side < 2; ++side) {
        if (side == 0 || !features.fixed_point) nodes[side] = DeviceArray<float4>(grid_nodes);
        if (features.fixed_point) sums[side] = DeviceArray<long long>(4 * grid_nodes);
    }
    for (DeviceArray<CellPressure>& each : cells)
        if (features.mean_pressure)
            each = DeviceArray<CellPressure>(std::size_t(lattice.node_count()));
    marks = DeviceArray<int>(blocks);
    if (!features.fixed_point) counts = DeviceArray<int>(std::size_t(lattice.node_count()));
    for (DeviceArray<int>& each : list) each = DeviceArray<int>(blocks);
    const auto at_end = std::make_unique<bool[]>(blocks);
    for (std::size_t b = 0; b < blocks; ++b)
        at_end[b] = ends_at(lattice, lattice.block_at(int(b))) != 0;
    rim = DeviceArray<bool>(blocks);
    upload(rim.data(), at_end.get(), blocks);
    if (features.tools) masks = DeviceArray<Mask>(blocks);
    if (!features.rests) return;
    for (DeviceArray<int>* each :
         {&quiet, &activity, &free, &guard, &woken[0], &woken[1], &changed})
        *each = DeviceArray<int>(blocks);
    for (DeviceArray<unsigned>* each : {&fastest, &reached}) *each = DeviceArray<unsigned>(blocks);
    ranges = DeviceArray<int2>(blocks);
}

std::size_t NodeArrays::bytes_for(const Lattice<float>& lattice, const Features& features)
{
    const std::size_t of_block = 4 * sizeof(int) + sizeof(bool) +
                                 (features.tools ? sizeof(Mask) : 0) +
                                 (features.rests ? 9 * sizeof(int) + sizeof(int2) : 0),
                      of_node =
                          std::size_t(field_count(features)) * (features.fixed_point ? 80 : 32) +
                          (features.fixed_point ? 0 : sizeof(int)) +
                          (features.mean_pressure ? 2 * sizeof(CellPressure) : 0);
    return std::size_t(lattice.block_count()) * of_block +
           std::size_t(lattice.node_count()) * of_node;
}

std::size_t NodeArrays::bytes() const
{
    std::size_t sum = marks.bytes() + counts.bytes() + rim.bytes() + masks.bytes() +
                      fastest.bytes() + reached.bytes() + quiet.bytes() + activity.bytes() +
                      free.bytes() + guard.bytes() + changed.bytes() + ranges.bytes();
    for (const DeviceArray<int>& each : list) sum += each.bytes();
    for (int s = 0; s < 2; ++s)
        sum += nodes[s].bytes() + sums[s].bytes() + woken[s].bytes() + cells[s].bytes();
    return sum;
}

void Store::point()
{
    all.stored = stored_region(all.lattice), all.free = free_region(all.lattice, all.walls);
    for (int side = 0; side < 2; ++side) {
        all.grid.nodes[side] = box.nodes[used.fixed_point ? 0 : side].data();
        all.grid.sums[side] = box.sums[side].data();
        all.rest.woken[side] = box.woken[side].data();
        all.pressure.cells[side] = box.cells[side].data();
    }
    all.grid.fields = field_count(used);
    all.grid.marks = box.marks.data(), all.grid.rim = box.rim.data();
    for (int k = 0; k < 3; ++k) all.grid.list[k] = box.list[k].data();
    all.tools.masks = box.masks.data();
    all.rest.quiet = box.quiet.data(), all.rest.fastest = box.fastest.data();
    all.rest.activity = box.activity.data(), all.rest.free = box.free.data();
    all.rest.guard = box.guard.data(), all.rest.range = box.ranges.data();
    all.rest.reached = box.reached.data(), all.rest.changed = box.changed.data();
}

// Allocates the new arrays before it frees the old ones. Strong guarantee.
void Store::set_box(const Lattice<float>& more)
{
    const Lattice<float> before = all.lattice;
    NodeArrays larger;
    try {
        if (room.max && std::size_t(more.node_count()) > room.max)
            DeviceArray<char>(std::size_t(1) << 50);
        larger = NodeArrays(more, used);
    } catch (const std::runtime_error&) {
        cudaGetLastError();  // clears the error, or the next launch would report it
        std::size_t unused = 0, total = 0;
        gpu::check(cudaMemGetInfo(&unused, &total), "memory");
        throw std::runtime_error("gpu: the clay has spread; beside the " +
                                 std::to_string(box.bytes() >> 20) +
                                 " MiB of its nodes the device needs " +
                                 std::to_string(NodeArrays::bytes_for(more, used) >> 20) +
                                 " MiB for a moment, and has " + std::to_string(unused >> 20));
    }
    const std::vector<int> quiet = box.quiet.downloaded();
    std::vector<int> same(larger.quiet.size());
    for (std::size_t b = 0; b < quiet.size() && !same.empty(); ++b) {
        const Int3 node = block_edge * before.block_at(int(b));
        if (more.stores(node)) same[std::size_t(more.block_of(node))] = quiet[b];
    }
    gpu::upload(larger.quiet.data(), same.data(), same.size());
    box = std::move(larger), all.lattice = more;
    point();
    Clock now = clock();
    for (int& active : now.active) active = 0;
    set_clock(now);
}

void Store::grow()
{
    const Clock now = clock();
    const std::vector<int> listed = box.list[(now.done + 2) % 3].downloaded();
    unsigned ends = 0;
    for (int k = 0; k < now.active[(now.done + 2) % 3]; ++k)
        ends |= ends_at(all.lattice, all.lattice.block_at(block_of(listed[std::size_t(k)])));
    set_box(grown(all.lattice, ends));
}

namespace {

// The nodes of the stencils of particles in a box: first and end.
struct NodeRange {
    Int3 first, end;
};
NodeRange nodes_around(const Box3<float>& clay, const Lattice<float>& l)
{
    return {base_node(clay.low, l.spacing), base_node(clay.high, l.spacing) + Int3{3, 3, 3}};
}

}  // namespace

bool Store::holds(const Box3<float>& clay) const
{
    const Lattice<float>& l = all.lattice;
    const auto [first, end] = nodes_around(clay, l);
    const Int3 stored = l.low + l.stored;
    return first.x >= l.low.x && first.y >= l.low.y && first.z >= l.low.z && end.x <= stored.x &&
           end.y <= stored.y && end.z <= stored.z;
}

void Store::enclose(const Box3<float>& clay)
{
    if (!used.fixed_point && holds(clay)) return;
    const Lattice<float> whole{all.lattice.size, all.lattice.dx};
    const auto [first, end] = nodes_around(clay, whole);
    const Lattice<float> fresh = box_around(whole, first, end, room.spare);
    if (!same_box(fresh, all.lattice)) set_box(fresh);
}

void Store::hold(const Box3<float>& clay)
{
    if (holds(clay)) return;
    const Lattice<float>& l = all.lattice;
    const auto [first, end] = nodes_around(clay, l);
    const Int3 stored = l.low + l.stored;
    if (count() == 0) return set_box(box_around({l.size, l.dx}, first, end, room.spare));
    const Int3 from{min(first.x, l.low.x), min(first.y, l.low.y), min(first.z, l.low.z)};
    const Int3 to{max(end.x, stored.x), max(end.y, stored.y), max(end.z, stored.z)};
    set_box(box_around({l.size, l.dx}, from, to, room.spare));
}

// Waits for a frame to complete, continuing it as often as it stops.
void GpuSolver::wait_for(int slot)
{
    watch(slot);
    wait(frames[slot].done, "substeps");
    while (frames[slot].duration > 0 && frames[slot].status->mode == Mode::stopped) go_on(slot);
}

// Continues a frame that has stopped after a substep; a frame submitted after it has had no effect
// and is launched again. Throws if there is no memory for more nodes; the frame then ends here.
void GpuSolver::go_on(int slot)
{
    wait(main, "substeps");
    const bool behind = slot == collected % 2 && submitted - collected == 2;
    Clock now = store.clock(main);
    now.mode = Mode::running;
    store.set_clock(now);
    store.grow();
    now = store.clock(main);
    now.mode = Mode::going_on;
    store.set_clock(now);
    show();
    if (!stepwise) capture();
    launch(slot);
    watch(slot);
    wait(frames[slot].done, "substeps");
    if (behind) launch(slot ^ 1);
}

}  // namespace knead::gpu
