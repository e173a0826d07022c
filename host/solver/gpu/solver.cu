// The GPU implementation of EditableSimulator. A frame is one graph: upload the input, sort, then
// substeps in a device-side loop until the frame's time is used up. The host waits only for the
// counters.
#include <algorithm>
#include <atomic>
#include <bit>
#include <cstdlib>

#include "cuda/device/device.cuh"
#include "host/base/machine.h"
#include "host/solver/gpu/solver.cuh"
#include "host/solver/pieces.h"

namespace knead {
namespace gpu {
namespace {

std::atomic<int> solvers = 0;  // constructed in this process so far

}  // namespace

GpuSolver::GpuSolver(const Setup& given, int wanted, RegionPadding room)
    : book(std::make_shared<const SceneState>(given)),
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
    store.recolour(config(), side, main);
    if (stepwise) return;
    capture();
}

// Publishes the device pointers from which the surface is built, with a new solver number.
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

// Substep count for which the graphs are captured: that of the first frame. After `patience`
// consecutive frames that deviate by more than a quarter, the graphs are captured again for the
// current count.
void GpuSolver::fit_graphs()
{
    constexpr int patience = 30;
    if (last_substeps == 0 || submitted != collected) return;
    const bool fit =
        4 * last_substeps >= 3 * usual_substeps && 4 * last_substeps <= 5 * usual_substeps;
    misfits = fit ? 0 : misfits + 1;
    if (fit || (usual_substeps > 0 && misfits < patience)) return;
    usual_substeps = last_substeps, misfits = 0, stale = true;
}

void GpuSolver::submit(const Motion& motion, double duration)
{
    if (submitted - collected == 2) throw std::logic_error("two frames are already in flight");
    check(cudaSetDevice(device), "device");
    fit_graphs();
    if (stale && !stepwise) capture();
    const int slot = submitted % 2;
    Frame& f = frames[slot];
    f.motion = motion, f.duration = store.count() > 0 ? duration : 0;
    // The slot's previous frame, two frames ago, is complete: its input is no longer read.
    const int bound = take_substep_bound();
    const bool tools = store.write_input(config(), motion, duration, bound, slot);
    f.tools = tool_speed_class(tools, motion, duration);
    if (!stepwise && !graph(f.tools).ready) capture(f.tools);
    launch(slot);
    // Cuts are completed on the host before the next frame.
    const bool waits = store.features().blades || store.shares_colours();
    f.welded_bodies = store.welded_bodies();
    if (waits && f.duration > 0) wait_for(slot);
    if (store.features().blades && f.duration > 0) finish_cuts(f);
    if (f.duration > 0 && store.recolour(config(), f.status->side, main))
        store.forget_sliding(main), stale = true;
    ++submitted;  // last: a frame that fails for lack of memory does not count
}

FrameStats GpuSolver::collect()
{
    if (submitted == collected) throw std::logic_error("no frame is in flight");
    const int slot = collected % 2;
    Frame& f = frames[slot];
    FrameStats stats;
    stats.fastest = extremes_of(peak).speed;
    if (!(f.duration > 0)) return ++collected, stats;
    check(cudaSetDevice(device), "device");
    const bool nothing_done = was_cut;
    try {
        wait_for(slot);
    } catch (...) {
        collected = submitted;  // the second frame in flight has ended, too
        throw;
    }
    ++collected;
    ++changes;
    const Clock& clock = *f.status.data();
    was_cut = clock.mode == Mode::cut;
    stats.cut = was_cut || clock.mode == Mode::bounded;
    if (halted && submitted == collected) end_halt();
    if (nothing_done) return stats;  // the previous frame was cut while this one was in flight
    if (stats.cut) stats.reached = clock.resume.start;
    posed = f.tools != ToolPace::none;
    side = clock.side, drift = clock.drift;
    peak = clock.peak(clock.done + 1);
    stats.fastest = extremes_of(peak).speed;
    const Counters& n = f.status->counters;
    stats.substeps = last_substeps = n.substeps;
    stats.dt_min = n.dt_min, stats.dt_max = n.dt_max;
    for (int l = 0; l < int(Limit::count); ++l) stats.limits[l] = n.limits[l];
    stats.counts = cast<long>(n.counts);
    const float skin = store.views().tools.pushout.skin;
    stats.found_depth = double(std::max(0.0f, std::bit_cast<float>(n.deepest) - skin));
    stats.active_blocks = n.active_blocks, stats.touched = n.touched;
    stats.welded_bodies = f.welded_bodies;
    if (!store.features().rests)
        stats[Count::moved] = long(store.views().particles[0].count) * n.substeps;
    stage_times.clear();
    return stats;
}

// Rare and global (connected pieces of the whole scene): on the host.
void GpuSolver::finish_cuts(const Frame& f)
{
    const bool covered = f.status->counters[Count::covered] > 0;
    if (covered == was_covered) return;
    const Lattice<double>& lattice = config().lattice;
    PosedTools<double> tools(config(), lattice);
    tools.activate(f.motion);
    tools.pose(f.motion, 0, 1, f.duration);
    tools.mask_blocks(lattice);
    std::vector<Particle<double>> q = store.particles();
    std::vector<Gaussian<double>> following = splats.all();
    const Bodies bodies = bodies_of(config());
    if (relabel_pieces(q, following, lattice, bodies, tools, covered, was_covered)) {
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

std::vector<Vec3<double>> GpuSolver::velocities() const
{
    std::vector<Vec3<double>> all;
    if (!posed || config().passes == 0) return all;
    check(cudaSetDevice(device), "device");
    gpu::velocities(store.views(), main);
    for (const float4& v : store.velocities(main)) all.push_back({v.x, v.y, v.z});
    return all;
}

}  // namespace gpu

std::unique_ptr<EditableSimulator> gpu_solver(const Setup& setup, int device)
{
    return gpu_solver(setup, device, {});
}

std::unique_ptr<EditableSimulator> gpu_solver(const Setup& setup, int device, RegionPadding room)
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
