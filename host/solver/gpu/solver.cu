// The device behind Solver. A frame is one graph: input in, sort, then substeps for as long as the
// device finds time left in the frame; the host waits for nothing but the counters.
#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdlib>
#include <limits>

#include "cuda/device/device.cuh"
#include "host/base/machine.h"
#include "host/solver/gpu/solver.cuh"
#include "host/solver/pieces.h"

namespace knead {
namespace gpu {
namespace {

// How many substeps each turn of the graph's loop holds, for frames of so many or a twentieth more:
// going round costs about 4 us, a substep that finds the frame over about 3. Always so many times
// follow_every: in which of them Gaussians follow is known when they are captured.
int substeps_a_turn(int substeps)
{
    constexpr int unit = follow_every;
    if (substeps == 0) return (4 + unit - 1) / unit * unit;
    int best = unit, min_cost = std::numeric_limits<int>::max();
    for (int each = unit == 1 ? 2 : unit; each <= 32; each += unit) {
        int worst = 0;
        for (int n = substeps; n <= substeps + substeps / 20; ++n) {
            const int turns = (n + each - 1) / each;
            worst = std::max(worst, turns + turns * each - n);
        }
        if (worst < min_cost) best = each, min_cost = worst;
    }
    return best;
}

std::atomic<int> solvers = 0;  // of the process so far

// Sums of fixed point are cleared, but velocities of blocks that clay has left stay until it comes
// back. No particle reads them; a Gaussian may.
void clear_velocities(const Views& views, cudaStream_t stream)
{
    const GridView& g = views.grid;
    const std::size_t nodes = std::size_t(g.fields) * std::size_t(views.lattice.node_count());
    check(cudaMemsetAsync(g.nodes[0], 0, nodes * sizeof *g.nodes[0], stream), "clear velocities");
}

}  // namespace

GpuSolver::GpuSolver(const Setup& given, int wanted, Room room)
    : book(std::make_shared<const Rules>(given)),
      device(chosen(wanted)),
      processors(multiprocessors(device)),
      store(given, room, device),
      peak(store.clock().peak(1)),
      drift(store.clock().drift)
{
    splats.set(given.gaussians, store.views().lattice);
    show();
    cudaDeviceProp properties;
    check(cudaGetDeviceProperties(&properties, device), "device");
    title = std::string("cuda: ") + properties.name;
    const char* graph = std::getenv("KNEAD_GRAPH");
    stepwise = graph && std::string(graph) == "0";
    if (stepwise) return;
    capture();
}

// What a surface goes by; by its number it is another clay's from now on.
void GpuSolver::show()
{
    const Views views = store.views();
    shown = {{views.particles[0], views.particles[1]},
             &views.clock->side,
             main,
             &views.clock->done,
             views.rest.changed,
             views.lattice,
             ++solvers};
    splats.show(main);
}

void GpuSolver::capture()
{
    capture(ToolPace::none);
    if (store.features().tools) capture(ToolPace::slow);
    graph(ToolPace::swift).drop();  // until it is needed
    stale = false;
}

Features GpuSolver::features_for(bool tools) const
{
    Features features = store.features();
    features.tools = tools || features.blades;  // a cut stays one when the hands have gone
    features.splats = splats.count() > 0;
    return features;
}

Views GpuSolver::views_for(const Features& features, ToolPace tools) const
{
    Views views = store.views();
    if (!features.tools) views.tools.primitives.count = views.tools.passes = 0;
    views.tools.swift = features.blades || tools == ToolPace::swift;
    return views;
}

// It matters to Gaussians alone.
GpuSolver::ToolPace GpuSolver::pace(bool tools, const Motion& motion, double duration) const
{
    if (!tools) return ToolPace::none;
    const bool swift = splats.count() > 0 && !store.features().blades &&
                       clears_each_time(false, duration, tool_step(rules(), motion, duration));
    return swift ? ToolPace::swift : ToolPace::slow;
}

// What comes before the first grid update. What tools may touch needs the frame's input alone, and
// the first pose only what begin() chooses: they run beside what is done with the particles.
void GpuSolver::start(const Views& views, const Features& features)
{
    const auto fork = [this](cudaStream_t to) {
        check(cudaEventRecord(forked, main), "fork");
        check(cudaStreamWaitEvent(to, forked, 0), "fork");
    };
    if (features.splats && features.fixed_point) clear_velocities(views, main);
    if (features.tools) {
        fork(beside);
        masks(views, beside);
        check(cudaEventRecord(masked, beside), "join");
    }
    begin(views, main);
    if (features.tools) {
        fork(posing);
        pose(views, posing);
        check(cudaEventRecord(posed_first, posing), "join");
    }
    const auto join = [&](cudaEvent_t done) {
        if (features.tools) check(cudaStreamWaitEvent(main, done, 0), "join");
    };
    if (features.rests) join(masked);  // what may be still depends on the tools
    sort_if_due(views, features);
    if (!features.rests) join(masked);
    join(posed_first);  // here, so that what follows p2g waits for it alone
    if (features.mean_pressure) find_pressures(views, main);
    p2g(views, features, processors, main);
}

void GpuSolver::sort(const Views& views, const Features& features, cudaStream_t stream,
                     int side) const
{
    sort_particles(views, features, store.sort_space(), side, stream);
    if (features.rests) update_activity(views, stream);
    arrange(views, features, stream);
}

// Particles that have hardly moved since the last sort are still in order; but where clay may be
// still, each frame begins with asking which is. A frame that does nothing, because the one before
// it has stopped, does not. A sort that must be told the side when it is launched is in the graph
// twice.
void GpuSolver::sort_if_due(const Views& views, const Features& features)
{
    for (int side = 0; views.conditions.captured && side < (told_side(features) ? 2 : 1); ++side)
        capture_body(add_conditional(main, cudaGraphCondTypeIf, views.conditions.unsorted[side]),
                     body, [&](cudaStream_t stream) { sort(views, features, stream, side); });
    if (views.conditions.captured) return;
    const Clock now = store.clock(main);
    if (now.unsorted) sort(views, features, main, now.side);
}

// Between grid and g2p, neither of which waits for a kernel other than the one before it. Beside
// g2p it would be hidden; a fork between kernels that start early crashed (driver 580).
void GpuSolver::follow(const Views& views, const Features& features, bool at_end,
                       cudaStream_t stream) const
{
    if (!features.splats) return;
    const float per_mass = float(1 / lightest_particle(rules()));
    deform(views, splats.view(), per_mass, features, at_end, stream);
}

// `place`: so many of the frame, or of whole turns of its loop, come before.
void GpuSolver::substep(const Views& views, const Features& features, int place,
                        cudaStream_t stream)
{
    grid(views, features, processors, stream);
    if (place % follow_every == follow_every - 1) follow(views, features, false, stream);
    if (features.mean_pressure) clear_pressures(views, processors, stream);
    g2p(views, features, processors, stream);
}

void GpuSolver::capture(ToolPace tools)
{
    const Features features = features_for(tools != ToolPace::none);
    Views views = views_for(features, tools);
    Graph& to = graph(tools);
    to.begin(main);
    const auto handle = [this](cudaGraphConditionalHandle& h) {
        check(cudaGraphConditionalHandleCreate(&h, under_capture(main), 1,
                                               cudaGraphCondAssignDefault),
              "conditional node");
    };
    handle(views.conditions.again);
    handle(views.conditions.unsorted[0]);
    if (told_side(features))
        handle(views.conditions.unsorted[1]);
    else
        views.conditions.unsorted[1] = views.conditions.unsorted[0];
    views.conditions.captured = true;
    start(views, features);
    const auto take_turn = [&](cudaStream_t stream) {
        for (int k = 0; k < (turn ? turn : substeps_a_turn(0)); ++k)
            substep(views, features, k, stream);
    };
    take_turn(main);  // of short frames all: the loop is not entered
    capture_body(add_conditional(main, cudaGraphCondTypeWhile, views.conditions.again), body,
                 take_turn);
    follow(views, features, true, main);
    to.end(main);
    check(cudaGraphUpload(to.ready, main), "graph");
    wait(main, "graph");
}

// The frame without its graph, the host asking after each substep whether there is another.
void GpuSolver::step_through(ToolPace tools)
{
    const Features features = features_for(tools != ToolPace::none);
    const Views views = views_for(features, tools);
    start(views, features);
    const auto under_way = [this] {
        Clock now = store.clock(main);
        return now.step(now.done).dt > 0;
    };
    for (int k = 0; under_way(); ++k) substep(views, features, k, main);
    follow(views, features, true, main);
}

void GpuSolver::launch(int slot)
{
    Frame& f = frames[slot];
    if (!(f.duration > 0)) return;
    const ProfilerRange range{"substeps"};
    store.send_input(slot, main);
    if (stepwise)
        step_through(f.tools);
    else
        check(cudaGraphLaunch(graph(f.tools).ready, main), "substeps");
    splats.show(main);
    check(cudaMemcpyAsync(f.status.data(), store.views().clock, sizeof(Clock),
                          cudaMemcpyDeviceToHost, main),
          "status");
    check(cudaEventRecord(f.done, main), "status");
}

void GpuSolver::submit(const Motion& motion, double duration)
{
    if (submitted - collected == 2) throw std::logic_error("two frames are under way already");
    check(cudaSetDevice(device), "device");
    // What the first frames took is what later ones will take, more or less.
    if (turn == 0 && last_substeps > 0 && submitted == collected)
        turn = substeps_a_turn(last_substeps), stale = true;
    if (stale && !stepwise) capture();
    const int slot = submitted % 2;
    Frame& f = frames[slot];
    f.motion = motion, f.duration = store.count() > 0 ? duration : 0;
    // Of two frames ago, which is over: its input is no longer read.
    f.tools = pace(store.write_input(rules(), motion, duration, slot), motion, duration);
    if (!stepwise && !graph(f.tools).ready) capture(f.tools);
    launch(slot);
    // What a cut leaves is settled by the host before the next frame.
    if (store.features().blades && f.duration > 0) wait_for(slot), finish_cuts(f);
    ++submitted;  // only now: a frame that finds no memory has ended
}

FrameStats GpuSolver::collect()
{
    if (submitted == collected) throw std::logic_error("no frame is under way");
    const int slot = collected % 2;
    Frame& f = frames[slot];
    FrameStats stats;
    if (!(f.duration > 0)) return ++collected, stats;
    check(cudaSetDevice(device), "device");
    const bool nothing_done = was_cut;
    try {
        wait_for(slot);
    } catch (...) {
        collected = submitted;  // the frame behind has ended, too
        throw;
    }
    ++collected;
    ++changes;
    const Clock& clock = *f.status.data();
    was_cut = clock.mode == Mode::cut;
    stats.cut = was_cut;
    if (halted && submitted == collected) end_halt();
    if (nothing_done) return stats;  // the frame before was cut while this one was under way
    if (stats.cut) stats.reached = clock.resume.start;
    posed = f.tools != ToolPace::none;
    side = clock.side, drift = clock.drift;
    peak = clock.peak(clock.done + 1);
    const Counters& n = f.status->counters;
    stats.substeps = last_substeps = n.substeps;
    stats.dt_min = n.dt_min, stats.dt_max = n.dt_max;
    for (int l = 0; l < int(Limit::count); ++l) stats.limits[l] = n.limits[l];
    stats.yielded = long(n.yielded), stats.projected = long(n.projected);
    stats.clipped = long(n.clipped), stats.confined = long(n.confined);
    stats.repaired = long(n.repaired);
    stats.abrupt = long(n.abrupt), stats.moved_far = long(n.moved_far);
    stats.trimmed = long(n.trimmed);
    const float skin = store.views().tools.way.skin;
    stats.found_depth = double(std::max(0.0f, std::bit_cast<float>(n.deepest) - skin));
    stats.active_blocks = n.active_blocks, stats.touched = n.touched;
    const long all = long(store.views().particles[0].count) * n.substeps;
    stats.moved = store.features().rests ? long(n.moved) : all;
    stats.woken = long(n.woken);
    stats.stranded = long(n.stranded), stats.splats_projected = long(n.splats_projected);
    stats.splats_repaired = long(n.splats_repaired);
    times.clear();
    return stats;
}

// Rare, and of the whole scene at once: done by the host.
void GpuSolver::finish_cuts(const Frame& f)
{
    const bool covered = f.status->counters.covered > 0;
    if (covered == was_covered) return;
    const Lattice<double>& lattice = rules().lattice;
    PosedTools<double> tools(rules(), lattice);
    tools.activate(f.motion);
    tools.pose(f.motion, 0, 1, f.duration);
    tools.mask_blocks(lattice);
    std::vector<Particle<double>> q = store.particles();
    std::vector<Gaussian<double>> following = splats.all();
    if (relabel_pieces(q, following, lattice, tools, covered, was_covered)) {
        store.set_sides(q);
        splats.set(following, store.views().lattice);
    }
    was_covered = covered;
}

std::vector<Particle<double>> GpuSolver::particles() const
{
    check(cudaSetDevice(device), "device");
    wait(main, "particles");
    return store.particles();
}

std::vector<Gaussian<double>> GpuSolver::gaussians() const
{
    check(cudaSetDevice(device), "device");
    wait(main, "Gaussians");
    return splats.all();
}

std::vector<double> GpuSolver::penetration() const
{
    std::vector<double> depths;
    if (!posed) return depths;
    check(cudaSetDevice(device), "device");
    gpu::penetration(store.views(), main);
    for (float d : store.depths(main))
        if (d > 0) depths.push_back(double(d));
    return depths;
}

}  // namespace gpu

std::unique_ptr<Solver> gpu_solver(const Setup& setup, int device)
{
    return gpu_solver(setup, device, {});
}

std::unique_ptr<Solver> gpu_solver(const Setup& setup, int device, Room room)
{
    return std::make_unique<gpu::GpuSolver>(setup, device, room);
}

long gpu_waits() { return gpu::waits; }

bool gpu_present()
{
    int count = 0;
    return cudaGetDeviceCount(&count) == cudaSuccess && count > 0;
}

std::string gpu_bus()
{
    int device = 0;
    char bus[64] = {};
    if (cudaGetDevice(&device) != cudaSuccess ||
        cudaDeviceGetPCIBusId(bus, int(sizeof bus), device) != cudaSuccess)
        return "";
    return bus;
}

}  // namespace knead
