// Watchdog for long frames: polls the device clock and stops the frame early if the StopCheck
// returns true.
#include <thread>

#include "cuda/device/device.cuh"
#include "host/base/machine.h"
#include "host/solver/gpu/solver.cuh"

namespace knead::gpu {
namespace {

// Delay before the first poll, and the polling interval [s]. Frames of a headset end before the
// first poll.
constexpr double patience = 0.03, every = 0.02;

}  // namespace

// Returns when the frame is complete, or soon after; immediately if there is no StopCheck. Copies
// the clock on a stream of its own, concurrently with the substeps, to find the frame's progress.
void GpuSolver::watch(int slot)
{
    const Frame& f = frames[slot];
    if (!has_stop_check()) return;
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

// Clears the halt flag so that later frames run. Precondition: no frame in flight.
void GpuSolver::end_halt()
{
    Clock clock = store.clock(main);
    clock.halt = 0;
    if (clock.mode == Mode::cut) clock.mode = Mode::running;
    store.set_clock(clock);
    halted = was_cut = false;
}

}  // namespace knead::gpu
