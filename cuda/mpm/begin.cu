// The start of a frame: sets the clock's duration and chooses the first substep.
#include "cuda/device/launch.cuh"
#include "cuda/mpm/stages.cuh"

namespace knead::gpu {
namespace {

// The last substep of a frame that begins with substep n and takes `most` at most (0: any number).
__device__ int last_of(int n, int most)
{
    constexpr int largest = 0x7fffffff;
    return most > 0 ? n + min(most - 1, largest - n) : n - 1;
}

// Starts a frame, or the remainder of one.
__device__ void begin_frame(const BeginView& d)
{
    Clock& c = *d.clock;
    c.duration = d.input->duration;
    c.tool_step = d.input->tool_step;
    const bool anew = c.mode != Mode::going_on;
    c.step(c.done) =
        anew ? step_at(d.limits, 0, c.extremes(c.done), c.tool_step, c.duration) : c.resume;
    if (anew) c.counters = {}, c.last = last_of(c.done, d.input->most_substeps);
    c.first = c.done, c.begun = c.done - 1;
    c.near_blocks = c.far_blocks = 0;
    c.mode = Mode::running;
    c.unsorted = d.rest != RestMode::none || c.drift > max_drift * d.limits.dx;
    // Relisting drops blocks that clay has left, and detects blocks on the rim again.
    c.relisted = !anew || c.unsorted || c.crowded[0] || c.crowded[1] || c.active[c.done % 3] == 0;
    if (c.relisted) c.active[c.done % 3] = 0;
    c.crowded[0] = c.crowded[1] = false;
}

__global__ void begin_kernel(const __grid_constant__ BeginView d)
{
    Clock& c = *d.clock;
    c.begins = c.mode != Mode::stopped && c.mode != Mode::cut, c.unsorted = false;
    if (c.begins) begin_frame(d);
    for (int& posed : c.posed) posed = -1;
    c.lag = {};  // also in a skipped frame: the previous frame has ended
    const Conditions& to = d.conditions;
    if (!to.captured) return;
    cudaGraphSetConditional(to.unsorted[c.side ^ 1], false);
    cudaGraphSetConditional(to.unsorted[c.side], c.unsorted);  // after: it may be the same
    cudaGraphSetConditional(to.again, c.begins);
}

}  // namespace

void begin(const Views& views, cudaStream_t stream)
{
    launch("begin", begin_kernel, 1, 1, stream, begin_view(views));
}

}  // namespace knead::gpu
