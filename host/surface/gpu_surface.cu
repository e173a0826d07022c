// What the device holds of a surface, the order of its stages, and the way back to the host.
#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>

#include "cuda/device/device.cuh"
#include "cuda/device/graph.cuh"
#include "cuda/surface/smooth.h"
#include "host/surface/device_mesh.cuh"
#include "host/surface/gpu_surface_store.cuh"

namespace knead {

using namespace gpu;

namespace {

struct Stage {
    const char* name;
    std::function<void(cudaStream_t)> launch;
};

// A rule that makes sense to the loops on the CPU does so here.
const SurfaceRule& checked(const SurfaceRule& rule)
{
    knead::surface({}, {}, rule);
    return rule;
}

}  // namespace

struct GpuSurface::State {
    int device, processors;
    bool fixed_room;
    SurfaceStore store;
    Stream stream;
    Event from, to;

    // What the last surface was made of.
    DeviceArray<float4> rows;
    Clay clay{};
    Graph graph;
    bool fresh = true;  // nothing may be kept of it
    KeptMeshes kept;

    State(const std::vector<Particle<double>>& particles,
          const std::vector<Material<double>>& materials, const SurfaceRule& rule, SurfaceRoom room,
          int wanted);
    std::vector<Stage> stages(const Clay& now) const;
    void prepare(const Clay& now);
    void forget_if_told(cudaStream_t on);
    void start(cudaStream_t on);
    void run();
    SurfaceRoom needed() const;
    void make(const Clay& now);
    double seconds_of(cudaGraphExec_t what);
    Clay uploaded(const std::vector<Particle<double>>& particles);
    Amounts before_block(int block) const;
};

GpuSurface::State::State(const std::vector<Particle<double>>& particles,
                         const std::vector<Material<double>>& materials, const SurfaceRule& rule,
                         SurfaceRoom room, int wanted)
    : device(chosen(wanted)),
      processors(multiprocessors(device)),
      fixed_room(room.vertices || room.triangles),
      store(particles, materials, checked(rule), room)
{
}

// The stages over particles that are where they are now, in their order.
std::vector<Stage> GpuSurface::State::stages(const Clay& now) const
{
    const SurfaceRule& rule = store.rule;
    const int steps = rule.smoothing == Smoothing::none ? 0 : rule.iterations;
    const bool swells = rule.smoothing == Smoothing::taubin;
    const int moves = swells ? 2 * steps : steps, rounds = store.rounds;
    SurfaceView d = store.view;
    d.whole = !now.changed;
    const ScanSpace s = store.space;
    const int n = processors;
    std::vector<Stage> stages{
        {"renew", [d, now](cudaStream_t on) { renew(d, now, on); }},
        {"clear", [d, n](cudaStream_t on) { clear(d, n, on); }},
        {"deposit", [d, now](cudaStream_t on) { deposit(d, now, on); }},
        {"list", [d](cudaStream_t on) { list(d, on); }},
        {"soften",
         [d, n, rounds](cudaStream_t on) {
             for (int round = 0; round < rounds; ++round) soften(d, round, n, on);
         }},
        {"count", [d, n](cudaStream_t on) { count(d, n, on); }},
        {"scan", [d, s](cudaStream_t on) { scan(d, s, on); }},
        {"march", [d, n, moves](cudaStream_t on) { march(d, moves & 1, n, on); }},
        {"relax",
         [d, n, moves, swells](cudaStream_t on) {
             for (int k = 0; k < moves; ++k)  // the last move ends in the first array
                 relax(d, (moves - k) & 1,
                       swells && k % 2 ? smooth_swell<float> : smooth_shrink<float>, n, on);
         }},
        {"shade", [d, n](cudaStream_t on) { shade(d, n, on); }}};
    if (moves == 0) stages.erase(stages.end() - 2);
    if (d.whole) stages.erase(stages.begin());
    return stages;
}

// The graph of a surface of these particles.
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
    for (const Stage& stage : stages(clay)) stage.launch(stream);
    graph.end(stream);
}

void GpuSurface::State::forget_if_told(cudaStream_t on)
{
    if (fresh) check(cudaMemsetAsync(store.view.seen, 0xff, sizeof(int), on), "surface");
    fresh = false;
}

void GpuSurface::State::start(cudaStream_t on)
{
    const ProfilerRange range{"surface"};
    forget_if_told(on);
    check(cudaGraphLaunch(graph.ready, on), "surface");
}

void GpuSurface::State::run()
{
    start(stream);
    wait(stream, "surface");
}

double GpuSurface::State::seconds_of(cudaGraphExec_t what)
{
    if (what == graph.ready) forget_if_told(stream);
    check(cudaEventRecord(from, stream), "surface");
    check(cudaGraphLaunch(what, stream), "surface");
    check(cudaEventRecord(to, stream), "surface");
    check(cudaEventSynchronize(to), "surface");
    float milliseconds = 0;
    check(cudaEventElapsedTime(&milliseconds, from, to), "surface");
    return 1e-3 * double(milliseconds);
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

// Vertices and triangles of the blocks before one.
Amounts GpuSurface::State::before_block(int block) const
{
    unsigned long long both = 0;
    check(cudaMemcpy(&both, store.before.data() + block, sizeof both, cudaMemcpyDefault),
          "download");
    return unpacked(both);
}

GpuSurface::GpuSurface(const std::vector<Particle<double>>& particles,
                       const std::vector<Material<double>>& materials, const SurfaceRule& rule,
                       SurfaceRoom room, int device)
    : state(std::make_unique<State>(particles, materials, rule, room, device))
{
}
GpuSurface::~GpuSurface() = default;

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

SurfaceRoom GpuSurface::room() const
{
    return {std::size_t(state->store.view.vertex_room),
            std::size_t(state->store.view.triangle_room)};
}

SurfaceStats GpuSurface::settled() const
{
    const SurfaceRoom has = room(), needs = needed();
    if (needs.vertices > has.vertices || needs.triangles > has.triangles)
        throw std::runtime_error(
            "the surface has " + std::to_string(needs.vertices) + " vertices and " +
            std::to_string(needs.triangles) + " triangles; on the device there is room for " +
            std::to_string(has.vertices) + " and " + std::to_string(has.triangles));
    const Faults faults = state->store.faults.downloaded().at(0);
    if (faults.crowded)
        throw std::runtime_error(
            "the density has overflowed: a node of the surface's lattice holds the volume of more "
            "than 64 particles and 16 times the rest density");
    return {long(faults.unusable), long(faults.outside)};
}

SurfaceWork GpuSurface::work() const
{
    const Progress progress = state->store.progress.downloaded().at(0);
    return {state->store.active.downloaded().at(2), progress.deposited, progress.softened};
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
        meshes.push_back(std::move(mesh));
    }
    return meshes;
}

Field GpuSurface::density(int category) const
{
    const auto found = state->store.kinds.find(category);
    if (found == state->store.kinds.end()) return {{}, {}, state->store.rule.lattice.dx, {}};
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

// Waits for it, and takes more room where it may.
void GpuSurface::State::make(const Clay& now)
{
    check(cudaSetDevice(device), "device");
    prepare(now);
    run();
    const SurfaceRoom needs = needed();
    const SurfaceRoom has{std::size_t(store.view.vertex_room),
                          std::size_t(store.view.triangle_room)};
    if (fixed_room || (needs.vertices <= has.vertices && needs.triangles <= has.triangles)) return;
    graph.drop();
    store.reserve({needs.vertices + needs.vertices / 4, needs.triangles + needs.triangles / 4});
    prepare(now);
    run();
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
    state->make(clay);
    const SurfaceStats found = settled();
    if (stats) *stats = found;
    std::vector<int> categories;
    for (const auto& [category, kind] : state->store.kinds) categories.push_back(category);
    return state->kept.kept(state->store.view, categories, state->device, state->stream);
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

std::vector<double> GpuSurface::replays(int count)
{
    std::vector<double> seconds;
    for (int k = 0; k < count && state->graph.ready; ++k)
        seconds.push_back(state->seconds_of(state->graph.ready));
    return seconds;
}

std::vector<StageTime> GpuSurface::stage_times()
{
    constexpr int copies = 20, repeats = 11;
    std::vector<StageTime> times;
    if (!state->graph.ready) return times;
    for (const Stage& stage : state->stages(state->clay)) {
        state->fresh = true;
        state->run();
        Graph alone;
        alone.begin(state->stream);
        for (int k = 0; k < copies; ++k) stage.launch(state->stream);
        alone.end(state->stream);
        std::vector<double> seconds;
        for (int k = 0; k < repeats; ++k) seconds.push_back(state->seconds_of(alone.ready));
        std::nth_element(seconds.begin(), seconds.begin() + repeats / 2, seconds.end());
        times.push_back({stage.name, seconds[repeats / 2] / copies});
    }
    state->fresh = true;
    state->run();
    return times;
}

std::vector<StageWork> GpuSurface::stage_counts()
{
    if (!state->graph.ready) return {};
    check(cudaSetDevice(state->device), "device");
    const std::vector<StageWork> counts = counted([this](const Watch& watch) {
        for (const Stage& stage : state->stages(state->clay)) {
            state->fresh = true;
            state->run();
            watch(stage.name,
                  [&] { stage.launch(state->stream), wait(state->stream, stage.name); });
        }
    });
    state->fresh = true;
    state->run();
    return counts;
}

std::size_t GpuSurface::memory() const
{
    return state->store.bytes() + state->rows.bytes() + state->kept.bytes();
}

}  // namespace knead
