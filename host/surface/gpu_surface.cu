// A surface on the device: its stages, their order, and downloads.
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>

#include "cuda/device/device.cuh"
#include "cuda/surface/smooth.h"
#include "host/surface/gpu_surface.h"
#include "host/surface/gpu_surface_state.cuh"

namespace knead {

using namespace gpu;

namespace {

// Validates the options by the check of the CPU version.
const SurfaceOptions& checked(const SurfaceOptions& options)
{
    knead::surface({}, {}, options);
    return options;
}

}  // namespace

GpuSurface::State::State(const std::vector<Particle<double>>& particles,
                         const std::vector<Material<double>>& materials,
                         const SurfaceOptions& options, SurfaceRoom room, int wanted)
    : device(chosen(wanted)),
      processors(multiprocessors(device)),
      fixed_room(room.vertices || room.triangles),
      store(particles, materials, checked(options), room)
{
}

// The stages for the present particles, in order.
std::vector<SurfaceStage> GpuSurface::State::stages(const Clay& now) const
{
    const SurfaceOptions& options = store.options;
    const int steps = options.smoothing == Smoothing::none ? 0 : options.iterations;
    const bool swells = options.smoothing == Smoothing::taubin;
    const int moves = swells ? 2 * steps : steps, rounds = store.rounds;
    SurfaceView d = store.view;
    d.whole = !now.changed;
    const ScanSpace s = store.space;
    const int n = processors;
    std::vector<SurfaceStage> stages{
        {"renew", [d, now](cudaStream_t on) { mark_dirty(d, now, on); }},
        {"remember", [d, n](cudaStream_t on) { save_densities(d, n, on); }},
        {"clear", [d, n](cudaStream_t on) { clear(d, n, on); }},
        {"deposit", [d, now](cudaStream_t on) { deposit(d, now, on); }},
        {"list", [d](cudaStream_t on) { list(d, on); }},
        {"soften",
         [d, n, rounds](cudaStream_t on) {
             for (int round = 0; round < rounds; ++round) smooth_density(d, round, n, on);
         }},
        {"count", [d, n](cudaStream_t on) { count(d, n, on); }},
        {"scan", [d, s](cudaStream_t on) { scan(d, s, on); }},
        {"march", [d, n, moves](cudaStream_t on) { march(d, moves & 1, n, on); }},
        {"relax",
         [d, n, moves, swells](cudaStream_t on) {
             for (int k = 0; k < moves; ++k)  // the last move writes the first array
                 relax(d, (moves - k) & 1,
                       swells && k % 2 ? smooth_swell<float> : smooth_shrink<float>, n, on);
         }},
        {"shade", [d, n](cudaStream_t on) { shade(d, n, on); }}};
    if (moves == 0) stages.erase(stages.end() - 2);
    if (!d.past) stages.erase(stages.begin() + 1);
    if (d.whole) stages.erase(stages.begin());
    return stages;
}

// Captures the graph of a surface of these particles.
void GpuSurface::State::prepare(const Clay& now)
{
    const auto same = [](const ParticleView& a, const ParticleView& b) {
        return a.rows == b.rows && a.count == b.count;
    };
    if (graph.ready && now.side == clay.side && now.solver == clay.solver &&
        now.changed == clay.changed && same(now.particles[0], clay.particles[0]) &&
        same(now.particles[1], clay.particles[1]))
        return;
    clay = now, fresh = true;
    graph.begin(stream);
    for (const SurfaceStage& stage : stages(clay)) stage.launch(stream);
    graph.end(stream);
}

void GpuSurface::State::apply_resets(cudaStream_t on)
{
    if (fresh) check(cudaMemsetAsync(store.view.last_substep, 0xff, sizeof(int), on), "surface");
    if ((fresh || skips_advance) && store.view.past)
        check(cudaMemsetAsync(store.view.past_valid, 0, sizeof(int), on), "surface");
    fresh = skips_advance = false;
}

void GpuSurface::State::start(cudaStream_t on)
{
    const ProfilerRange range{"surface"};
    apply_resets(on);
    check(cudaGraphLaunch(graph.ready, on), "surface");
}

void GpuSurface::State::run()
{
    start(stream);
    wait(stream, "surface");
}

Clay GpuSurface::State::uploaded(const std::vector<Particle<double>>& particles)
{
    const std::size_t n = particles.size();
    if (n > std::size_t(200000000))
        throw std::runtime_error("a surface of " + std::to_string(n) + " particles is too large");
    std::vector<float4> host_rows(particle_rows * n);
    const ParticleView on_host{host_rows.data(), nullptr, int(n)};
    for (std::size_t i = 0; i < n; ++i) on_host.store(int(i), cast<float>(particles[i]));
    if (rows.size() != host_rows.size()) {
        graph.drop();
        rows = {}, rows = DeviceArray<float4>(host_rows.size());
    }
    upload(rows.data(), host_rows.data(), host_rows.size());
    const ParticleView view_of_rows{rows.data(), nullptr, int(n)};
    return {{view_of_rows, view_of_rows}, nullptr};
}

// Numbers of vertices and triangles in the blocks before `block`.
Amounts GpuSurface::State::before_block(int block) const
{
    unsigned long long both = 0;
    check(cudaMemcpy(&both, store.before.data() + block, sizeof both, cudaMemcpyDefault),
          "download");
    return unpacked(both);
}

GpuSurface::GpuSurface(const std::vector<Particle<double>>& particles,
                       const std::vector<Material<double>>& materials,
                       const SurfaceOptions& options, SurfaceRoom room, int device)
    : state(std::make_unique<State>(particles, materials, options, room, device))
{
}
// Waits for the launched surface, which uses the memory freed here.
GpuSurface::~GpuSurface()
{
    if (state->under_way && cudaEventSynchronize(state->under_way->written) != cudaSuccess)
        cudaGetLastError();
}

// Waits for kernels that read the table before writing it.
bool GpuSurface::State::set_materials(const std::vector<Material<double>>& materials)
{
    check(cudaSetDevice(device), "device");
    if (!store.serves(materials)) return false;
    if (under_way) wait(under_way->written, "surface");
    wait(stream, "surface");
    graph.drop();
    store.set_materials(materials);
    return true;
}
bool GpuSurface::set_materials(const std::vector<Material<double>>& materials)
{
    return state->set_materials(materials);
}

void GpuSurface::launch(const Clay& clay)
{
    state->prepare(clay);
    state->start(clay.stream);
}

const SurfaceView& GpuSurface::view() const { return state->store.view; }

SurfaceRoom GpuSurface::State::needed() const
{
    const Amounts all = before_block(store.view.blocks);
    return {all.vertices, all.triangles};
}
SurfaceRoom GpuSurface::needed() const { return state->needed(); }

SurfaceRoom GpuSurface::State::room() const
{
    return {std::size_t(store.view.vertex_room), std::size_t(store.view.triangle_room)};
}
SurfaceRoom GpuSurface::room() const { return state->room(); }

bool GpuSurface::State::fits(const SurfaceRoom& needs) const
{
    return needs.vertices <= room().vertices && needs.triangles <= room().triangles;
}

void GpuSurface::State::take_room(const SurfaceRoom& needs)
{
    graph.drop();
    store.reserve({needs.vertices + needs.vertices / 4, needs.triangles + needs.triangles / 4});
}

SurfaceStats GpuSurface::State::settled(const SurfaceRoom& needs, const SurfaceErrors& errors) const
{
    const SurfaceRoom has = room();
    if (!fits(needs))
        throw std::runtime_error(
            "the surface has " + std::to_string(needs.vertices) + " vertices and " +
            std::to_string(needs.triangles) + " triangles; on the device there is room for " +
            std::to_string(has.vertices) + " and " + std::to_string(has.triangles));
    if (errors.overflowed)
        throw std::runtime_error(
            "the density has overflowed: a node of the surface's lattice holds the volume of more "
            "than 64 particles and 16 times the rest density");
    return {long(errors.unusable), long(errors.outside)};
}

SurfaceStats GpuSurface::settled() const
{
    return state->settled(state->needed(), state->store.errors.downloaded().at(0));
}

SurfaceWork GpuSurface::work() const
{
    const Progress progress = state->store.progress.downloaded().at(0);
    return {state->store.active.downloaded().at(2), progress.deposited, progress.smoothed};
}

std::vector<Mesh> GpuSurface::meshes() const
{
    std::vector<Mesh> meshes;
    const SurfaceView& d = state->store.view;
    const std::vector<DrawCommand> draws = state->store.draws.downloaded();
    const auto download = [](auto& to, const auto* from, std::size_t first) {
        check(cudaMemcpy(to.data(), from + first, to.size() * sizeof to[0], cudaMemcpyDefault),
              "download");
    };
    std::size_t c = 0;
    for (const auto& [category, kind] : state->store.kinds) {
        const DrawCommand draw = draws[c];
        const unsigned first = state->before_block(int(c) * d.layer_blocks()).vertices;
        const unsigned end = state->before_block(int(++c) * d.layer_blocks()).vertices;
        if (draw.count == 0) continue;
        Mesh mesh;
        mesh.category = category;
        mesh.triangles.resize(draw.count / 3);
        download(mesh.triangles, d.triangles, draw.first_index / 3);
        for (Int3& t : mesh.triangles) t = t - Int3{int(first), int(first), int(first)};
        std::vector<float4> places(end - first), normals(end - first);
        download(places, d.vertices[0], first);
        download(normals, d.normals, first);
        for (const float4& x : places) mesh.vertices.push_back({x.x, x.y, x.z});
        for (const float4& n : normals) mesh.normals.push_back({n.x, n.y, n.z});
        if (d.past)
            for (const float4& n : normals) mesh.advance.push_back(n.w);
        meshes.push_back(std::move(mesh));
    }
    return meshes;
}

Field GpuSurface::density(int category) const
{
    const auto found = state->store.kinds.find(category);
    if (found == state->store.kinds.end()) return {{}, {}, state->store.options.lattice.dx, {}};
    const auto c = std::size_t(std::distance(state->store.kinds.begin(), found));
    const SurfaceView& d = state->store.view;
    const Int3 one{1, 1, 1}, size = d.lattice.size + 2 * one;
    std::vector<float> all(std::size_t(d.categories) * std::size_t(d.layer_nodes()));
    check(cudaMemcpy(all.data(), d.final_density(), all.size() * sizeof(float), cudaMemcpyDefault),
          "download");
    Field field{{-1, -1, -1}, size, d.lattice.dx, {}};
    field.value.reserve(std::size_t(size.x) * size.y * size.z);
    const float* const layer = all.data() + c * std::size_t(d.layer_nodes());
    for (int z = 0; z < size.z; ++z)
        for (int y = 0; y < size.y; ++y)
            for (int x = 0; x < size.x; ++x)
                field.value.push_back(layer[d.padded.index({x, y, z})]);
    return field;
}

// Launches and waits. Grows the capacity unless it is fixed.
void GpuSurface::State::make(const Clay& now)
{
    check(cudaSetDevice(device), "device");
    if (under_way) wait(under_way->written, "surface");
    prepare(now);
    run();
    const SurfaceRoom needs = needed();
    if (fixed_room || fits(needs)) return;
    take_room(needs);
    prepare(now);
    run();
}

void GpuSurface::State::launch_kept(const Clay& now, cudaStream_t on)
{
    check(cudaSetDevice(device), "device");
    if (under_way) check(cudaStreamWaitEvent(on, under_way->written, 0), "surface");
    prepare(now);
    start(on);
    under_way = kept.launch(store.view, device, on);
}
void GpuSurface::launch_kept(const Clay& clay) { state->launch_kept(clay, clay.stream); }

// A single wait: all statistics were copied with the mesh.
std::shared_ptr<const DeviceMesh> GpuSurface::State::launched(SurfaceStats* stats)
{
    if (!under_way) return nullptr;
    check(cudaSetDevice(device), "device");
    const std::shared_ptr<KeptMesh> made = std::exchange(under_way, nullptr);
    wait(made->written, "surface");
    const MeshInfo facts = *made->host_info.data();
    const SurfaceRoom needs{facts.needed.vertices, facts.needed.triangles};
    if (!fixed_room && !fits(needs)) return take_room(needs), nullptr;
    const SurfaceStats found = settled(needs, facts.errors);
    if (stats) *stats = found;
    std::vector<int> categories;
    for (const auto& [category, kind] : store.kinds) categories.push_back(category);
    return std::make_shared<const DeviceMesh>(made, categories, facts);
}
std::shared_ptr<const DeviceMesh> GpuSurface::launched(SurfaceStats* stats)
{
    return state->launched(stats);
}

std::vector<Mesh> GpuSurface::surface(const Clay& clay, SurfaceStats* stats)
{
    state->make(clay);
    const SurfaceStats found = settled();
    if (stats) *stats = found;
    return meshes();
}

std::shared_ptr<const DeviceMesh> GpuSurface::kept(const Clay& clay, SurfaceStats* stats)
{
    for (;;) {
        state->launch_kept(clay, state->stream);
        if (auto made = state->launched(stats)) return made;
    }
}

std::shared_ptr<const DeviceMesh> GpuSurface::kept(const std::vector<Particle<double>>& particles,
                                                   SurfaceStats* stats)
{
    check(cudaSetDevice(state->device), "device");
    return kept(state->uploaded(particles), stats);
}

std::vector<Mesh> GpuSurface::surface(const std::vector<Particle<double>>& particles,
                                      SurfaceStats* stats)
{
    check(cudaSetDevice(state->device), "device");
    return surface(state->uploaded(particles), stats);
}

void GpuSurface::forget() { state->fresh = true; }
void GpuSurface::reset_advance() { state->skips_advance = true; }

std::size_t GpuSurface::memory() const
{
    return state->store.bytes() + state->rows.bytes() + state->kept.bytes();
}

}  // namespace knead
