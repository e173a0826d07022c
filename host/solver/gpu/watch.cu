// Frames that take long are looked in on while they run, and cut where who watches them asks.
#include <thread>

#include "cuda/device/device.cuh"
#include "host/base/machine.h"
#include "host/solver/gpu/solver.cuh"

namespace knead::gpu {
namespace {

// How long a frame may take before it is looked in on, and then how often [s]. Frames that a
// headset shows are over by then.
constexpr double patience = 0.03, every = 0.02;

}  // namespace

// Returns when the frame is over, or soon after; nothing is watched where nobody asked for it. A
// copy of the clock says how far it has come: beside the substeps, on a stream of its own.
void GpuSolver::watch(int slot)
{
    const Frame& f = frames[slot];
    if (!watched()) return;
    const double start = wall_seconds();
    double last = start + patience - every;
    while (!is_over(f.done, "substeps")) {
        std::this_thread::yield();
        if (wall_seconds() - last < every) continue;
        last = wall_seconds();
        const auto* clock = store.views().clock;
        check(cudaMemcpyAsync(seen.data(), clock, sizeof(Clock), cudaMemcpyDeviceToHost, asking),
              "a look at a frame");
        check(cudaStreamSynchronize(asking), "a look at a frame");
        FrameStats so_far;
        so_far.substeps = seen->counters.substeps;
        if (halted || !ends_here(seen->step(seen->done).start, f.duration, so_far)) continue;
        *halt.data() = 1, halted = true;
        check(cudaMemcpyAsync(&store.views().clock->halt, halt.data(), sizeof(int),
                              cudaMemcpyHostToDevice, asking),
              "the end of a frame");
        check(cudaStreamSynchronize(asking), "the end of a frame");
    }
}

// The device takes frames up again; none is under way.
void GpuSolver::end_halt()
{
    Clock clock = store.clock(main);
    clock.halt = 0;
    if (clock.mode == Mode::cut) clock.mode = Mode::running;
    store.set_clock(clock);
    halted = was_cut = false;
}

}  // namespace knead::gpu
