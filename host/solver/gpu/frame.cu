// The stages of a frame on the device in order, captured in a graph or launched one by one.
#include <algorithm>
#include <limits>

#include "host/solver/gpu/solver.cuh"
#include "host/solver/pieces.h"

namespace knead::gpu {
namespace {

// Substeps in the graph: unrolled before its while loop, and per iteration of the loop.
struct Turns {
    int first, each;
};

// Upper bound of the substeps that a frame needs beyond those of the first frame when clay is under
// pressure: compressed clay is stiffer and needs a shorter dt. Zero for a fixed dt.
int more_in_contact(int substeps, const StepLimits& limits)
{
    return limits.fixed > 0 ? 0 : (substeps + 19) / 20;
}

// For frames of `substeps` to `substeps + more` substeps (0: unknown). An empty substep after the
// end of the frame costs 3 us (11 us with a million particles), an iteration of the loop twice that
// in addition; capturing costs some 10 us per substep. With Gaussians both numbers are multiples of
// follow_every, because the substeps in which Gaussians follow are fixed at capture.
Turns turns_for(int substeps, int more, bool splats)
{
    constexpr int fewest = 4, most_each = 32, most_before = 256;
    const int unit = splats ? follow_every : 1;
    const auto whole = [unit](int n) { return (n + unit - 1) / unit * unit; };
    if (substeps == 0) return {whole(fewest), whole(fewest)};
    const int first = whole(std::min(substeps + more, most_before));
    int best = whole(fewest), min_cost = std::numeric_limits<int>::max();
    for (int each = best; each <= most_each; each += unit) {
        int worst = 0;
        for (int n = std::max(first, substeps); n <= substeps + more; ++n) {
            const int turns = (n - first + each - 1) / each;
            worst = std::max(worst, first + 2 * turns + turns * each - n);
        }
        if (worst < min_cost) best = each, min_cost = worst;
    }
    return {first, best};
}

// In fixed point only the sums are cleared: when clay leaves a block, its old velocities remain
// until clay returns. Particles never read them; Gaussians may.
void clear_velocities(const Views& views, cudaStream_t stream)
{
    const GridView& g = views.grid;
    const std::size_t nodes = std::size_t(g.fields) * std::size_t(views.lattice.node_count());
    check(cudaMemsetAsync(g.nodes[0], 0, nodes * sizeof *g.nodes[0], stream), "clear velocities");
}

}  // namespace

void GpuSolver::capture()
{
    capture(ToolPace::none);
    if (store.features().tools) capture(ToolPace::slow);
    graph(ToolPace::fast).drop();  // captured on demand
    stale = false;
}

Features GpuSolver::features_for(bool tools) const
{
    Features features = store.features();
    // Labels of a cut persist without an active blade; kernels for bodies are those with tools.
    features.tools = tools || features.blades || features.bodies;
    features.splats = splats.count() > 0;
    return features;
}

Views GpuSolver::views_for(const Features& features, ToolPace tools) const
{
    Views views = store.views();
    if (!features.tools) views.tools.primitives.count = views.tools.passes = 0;
    views.tools.fast = features.blades || tools == ToolPace::fast;
    views.overlaps = overlaps;
    return views;
}

// The distinction between slow and fast tools affects Gaussians only.
GpuSolver::ToolPace GpuSolver::tool_speed_class(bool tools, const Motion& motion,
                                                double duration) const
{
    if (!tools) return ToolPace::none;
    const bool fast = splats.count() > 0 && !store.features().blades &&
                      clears_each_time(false, duration, tool_step(config(), motion, duration));
    return fast ? ToolPace::fast : ToolPace::slow;
}

// Everything before the first grid update, in plain order. Masks come first: with sleep the sort
// needs the tools' sweep.
void GpuSolver::start(const Views& views, const Features& features)
{
    if (features.splats && features.fixed_point) clear_velocities(views, main);
    if (features.tools) masks(views, main);
    begin(views, main);
    if (features.tools) pose(views, main);
    sort_if_due(views, features);
    if (features.tools) line_up(views, features, main);
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

// The sort is skipped while the particles have hardly moved since the last one, and in a frame that
// does nothing because the previous one has stopped. With sleeping it is never skipped in a running
// frame, because the activity of blocks is updated with it. In fixed point the side is a launch
// argument: the graph contains the sort twice, once per side.
void GpuSolver::sort_if_due(const Views& views, const Features& features)
{
    for (int side = 0; views.conditions.captured && side < (side_at_launch(features) ? 2 : 1);
         ++side)
        capture_body(add_conditional(main, cudaGraphCondTypeIf, views.conditions.unsorted[side]),
                     body, [&](cudaStream_t to) { sort(views, features, to, side); });
    if (views.conditions.captured) return;
    const Clock now = store.clock(main);
    if (now.unsorted) sort(views, features, main, now.side);
}

// Between grid and g2p. On a stream parallel to g2p its time would be hidden, but a fork between
// kernels with programmatic dependent launch crashed (driver 580).
void GpuSolver::follow(const Views& views, const Features& features, bool at_end,
                       cudaStream_t stream) const
{
    if (!features.splats) return;
    const float per_mass = float(1 / lightest_particle(config()));
    deform(views, splats.view(), per_mass, features, at_end, stream);
}

// `place`: index of the substep in the frame, or in the iteration of the loop. `begins`: true
// directly after start().
void GpuSolver::substep(const Views& views, const Features& features, int place, bool begins,
                        cudaStream_t stream)
{
    separate(views, features, processors, stream);
    grid(views, features, processors, stream, begins);
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
    if (side_at_launch(features))
        handle(views.conditions.unsorted[1]);
    else
        views.conditions.unsorted[1] = views.conditions.unsorted[0];
    views.conditions.captured = true;
    start(views, features);
    const int more = more_in_contact(usual_substeps, views.limits);
    const Turns turns = turns_for(usual_substeps, more, features.splats);
    const auto take = [&](int count, bool begins, cudaStream_t stream) {
        for (int k = 0; k < count; ++k) substep(views, features, k, begins && k == 0, stream);
    };
    take(turns.first, true, main);
    capture_body(add_conditional(main, cudaGraphCondTypeWhile, views.conditions.again), body,
                 [&](cudaStream_t stream) { take(turns.each, false, stream); });
    follow(views, features, true, main);
    to.end(main);
    check(cudaGraphUpload(to.ready, main), "graph");
    wait(main, "graph");
}

// The frame without a graph: the host reads the clock before each substep.
void GpuSolver::step_through(ToolPace tools)
{
    const Features features = features_for(tools != ToolPace::none);
    const Views views = views_for(features, tools);
    start(views, features);
    const auto under_way = [this] {
        Clock now = store.clock(main);
        return now.step(now.done).dt > 0;
    };
    for (int k = 0; under_way(); ++k) substep(views, features, k, k == 0, main);
    follow(views, features, true, main);
}

}  // namespace knead::gpu
