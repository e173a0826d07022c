// Device memory of a surface: sized, allocated once, cleared.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cuda/surface/density.h"
#include "host/surface/gpu_surface_store.cuh"

namespace knead::gpu {
namespace {

// Fixed-point quantum. A sum holds 2^32 units: 128 of the largest particles, and at least 32 times
// the rest density.
float quantum_of(float share) { return std::ldexp(1.0f, std::ilogb(max(128 * share, 32.0f)) - 31); }

void require_memory(double bytes, const std::string& what)
{
    std::size_t free = 0, total = 0;
    check(cudaMemGetInfo(&free, &total), "memory");
    if (bytes > double(free))
        throw std::runtime_error(
            "gpu: " + what + " needs " + std::to_string(std::llround(bytes / 1048576)) +
            " MiB, the device has " + std::to_string(free >> 20) + " MiB free");
}

}  // namespace

SurfaceStore::SurfaceStore(const std::vector<Particle<double>>& particles,
                           const std::vector<Material<double>>& materials,
                           const SurfaceOptions& given, SurfaceRoom room)
    : options(given)
{
    sort_out(particles, materials);
    allocate();
    reserve(room);
}

float SurfaceStore::cell() const
{
    return options.lattice.dx * options.lattice.dx * options.lattice.dx;
}

// Volume of a particle at rest [m^3]; 0 for invalid materials.
float SurfaceStore::volume(const Material<double>& material) const
{
    const float v = float(material.mass / material.density);
    return v > 0 && std::isfinite(v / cell()) ? v : 0.0f;
}

// Scale of a category whose largest particle has this volume at rest [m^3].
CategoryScale SurfaceStore::scale_of(float largest) const
{
    return {quantum_of(largest / cell()), smoothing_passes(largest, options.lattice.dx)};
}

// Collects the categories, ascending.
void SurfaceStore::sort_out(const std::vector<Particle<double>>& particles,
                            const std::vector<Material<double>>& materials)
{
    for (const Particle<double>& q : particles) {
        if (q.object < 0 || std::size_t(q.object) >= materials.size()) continue;
        const Material<double>& m = materials[std::size_t(q.object)];
        const float v = volume(m);
        if (!(v > 0)) continue;
        Kind& kind = kinds[m.category];
        kind.volume = std::max(kind.volume, v);
        kind.amount += double(v / cell());
    }
    for (const auto& [category, kind] : kinds) {
        each_scale.push_back(scale_of(kind.volume));
        amount += kind.amount;
    }
    if (kinds.empty()) each_scale.push_back({1, 0});  // a launch needs at least one layer
    int max_passes = 0;
    for (const CategoryScale& scale : each_scale)
        max_passes = std::max(max_passes, scale.smoothing_passes);
    rounds = std::max(1, (max_passes + passes_a_round - 1) / passes_a_round);
    view.rounds = rounds;
    view.reach = max_passes + 1;  // the nodes of a cell extend one step further
    scales = DeviceArray<CategoryScale>(each_scale);
    set_materials(materials);
}

// A category may have lost its clay; its layer is then empty. One that has lost its largest
// particles may have another scale.
bool SurfaceStore::serves(const std::vector<Material<double>>& materials) const
{
    std::map<int, float> largest;  // by category
    for (const Material<double>& m : materials)
        if (const float v = volume(m); v > 0)
            largest[m.category] = std::max(largest[m.category], v);
    return std::all_of(largest.begin(), largest.end(), [this](const auto& wanted) {
        const auto found = kinds.find(wanted.first);
        if (found == kinds.end() || wanted.second > found->second.volume) return false;
        const auto index = std::size_t(std::distance(kinds.begin(), found));
        const CategoryScale scale = scale_of(wanted.second), has = each_scale[index];
        return scale.quantum == has.quantum && scale.smoothing_passes == has.smoothing_passes;
    });
}

// Sets the contribution of each object to its category. A later object must not have larger
// particles than the initial ones.
void SurfaceStore::set_materials(const std::vector<Material<double>>& materials)
{
    std::vector<ObjectDeposit> each;
    for (const Material<double>& m : materials) {
        const auto found = kinds.find(m.category);
        const int index = int(std::distance(kinds.begin(), found));
        const float share = volume(m) / cell();
        const bool usable = found != kinds.end() && volume(m) <= found->second.volume;
        each.push_back(usable ? ObjectDeposit{share / each_scale[std::size_t(index)].quantum, index}
                              : ObjectDeposit{0, 0});
    }
    if (object_deposits.size() < each.size())
        object_deposits = DeviceArray<ObjectDeposit>(each.size() + each.size() / 2);
    upload(object_deposits.data(), each.data(), each.size());
    view.first = each.empty() ? ObjectDeposit{} : each[0];
    view.object_deposits = {object_deposits.data(), int(each.size())};
}

// Allocates everything that depends on the lattice.
void SurfaceStore::allocate()
{
    const auto padded = [](int n) { return (n + 2 + block_edge - 1) / block_edge * block_edge; };
    const Int3 n = options.lattice.size;
    const Int3 size{padded(n.x), padded(n.y), padded(n.z)};
    const double all = double(scales.size()) * size.x * size.y * size.z;
    const std::string named = std::to_string(std::llround(all)) + " nodes";
    if (all > double(1 << 30))
        throw std::runtime_error("the density needs " + named +
                                 "; a surface is made from at most 2^30");
    require_memory((9.0 + 4 * (rounds + options.moving)) * all, "a density of " + named);
    const auto nodes = std::size_t(all), places = nodes / block_nodes;
    view.lattice = options.lattice;
    view.padded = {size, options.lattice.dx};
    view.categories = int(scales.size());
    view.blocks = int(places);
    view.iso = options.iso;
    sums = DeviceArray<unsigned>(nodes);
    marks = DeviceArray<unsigned>(nodes);
    densities = DeviceArray<float>(std::size_t(rounds) * nodes);
    occupied = DeviceArray<unsigned>(places);
    blocks = DeviceArray<int>(places);
    skin = DeviceArray<int>(places), work = DeviceArray<int>(places);
    dirty = DeviceArray<unsigned>(places / scales.size());
    last_substep = DeviceArray<int>(1), progress = DeviceArray<Progress>(1);
    active = DeviceArray<int>(3);
    counts = DeviceArray<unsigned long long>(places + 1);
    before = DeviceArray<unsigned long long>(places + 1);
    draws = DeviceArray<DrawCommand>(scales.size());
    errors = DeviceArray<SurfaceErrors>(1);
    scratch = DeviceArray<unsigned char>(scan_scratch_bytes(view.blocks));
    space = {scratch.data(), scratch.size()};
    view.scales = scales.data();
    view.sums = sums.data(), view.marks = marks.data(), view.occupied = occupied.data();
    view.list = blocks.data(), view.skin = skin.data(), view.active = active.data();
    view.counts = counts.data(), view.before = before.data();
    view.draws = draws.data(), view.errors = errors.data();
    view.density = densities.data(), view.dirty = dirty.data(), view.work = work.data();
    view.last_substep = last_substep.data(), view.progress = progress.data();
    if (!options.moving) return;
    past = DeviceArray<float>(nodes), past_valid = DeviceArray<int>(1);
    view.past = past.data(), view.past_valid = past_valid.data();
}

// Allocates everything that depends on the mesh. An interior node has at most 1 / iso of clay, and
// six edges; a smooth surface has far fewer vertices than that: the default is two per node full of
// clay.
void SurfaceStore::reserve(SurfaceRoom room)
{
    constexpr double min_room = 16384, max_room = 100e6;
    if (room.vertices == 0) room.vertices = std::size_t(clamp(2 * amount, min_room, max_room));
    if (room.triangles == 0) room.triangles = 2 * room.vertices;
    if (room.vertices > std::size_t(INT32_MAX) || room.triangles > std::size_t(INT32_MAX / 3))
        throw std::runtime_error("a surface of " + std::to_string(room.triangles) +
                                 " triangles is too large");
    const std::size_t n = room.vertices;
    vertices[0] = {}, vertices[1] = {}, normals = {}, triangles = {};
    ring = {}, next = {}, last = {};
    require_memory((52.0 + 8 * max_ring) * double(n) + 12.0 * double(room.triangles),
                   "a surface of " + std::to_string(n) + " vertices");
    for (auto& places : vertices) places = DeviceArray<float4>(n);
    normals = DeviceArray<float4>(n);
    ring = DeviceArray<int>(n);
    next = DeviceArray<int>(max_ring * n);
    last = DeviceArray<int>(max_ring * n);
    triangles = DeviceArray<Int3>(room.triangles);
    view.vertex_room = int(n), view.triangle_room = int(room.triangles);
    for (int k = 0; k < 2; ++k) view.vertices[k] = vertices[k].data();
    view.normals = normals.data(), view.triangles = triangles.data();
    view.ring = ring.data(), view.next = next.data(), view.last = last.data();
}

std::size_t SurfaceStore::bytes() const
{
    const auto sum = [](const auto&... arrays) { return (std::size_t(0) + ... + arrays.bytes()); };
    return sum(object_deposits, scales, sums, marks, occupied, dirty, densities, past, past_valid,
               blocks, skin, work, last_substep, progress, active, ring, next, last, counts, before,
               vertices[0], vertices[1], normals, triangles, draws, errors, scratch);
}

}  // namespace knead::gpu
