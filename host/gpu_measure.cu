// What each stage of a frame takes.
#include "gpu_solver.cuh"

namespace knead::gpu {

// Asking is measuring: a few substeps are run stage by stage from where the last frame ended, and
// forgotten: the sort that they begin with leaves its input as it was. Shares of one frame of the
// graph, in which stages overlap.
const std::vector<StageTime>& GpuSolver::stage_times() const
{
    if (times.empty() && last_substeps > 0) {
        wait(main, "measure");
        measure();
    }
    return times;
}

void GpuSolver::measure() const
{
    check(cudaSetDevice(device), "device");
    constexpr int warm = 2, repeats = 10;
    Needs needs = store.needs();
    needs.tools = posed || needs.blades;
    const Views views = views_for(needs);
    Event from, to;
    const auto timed = [&](const char* stage, auto&& run) {
        check(cudaEventRecord(from, main), stage);
        run();
        check(cudaEventRecord(to, main), stage);
        check(cudaEventSynchronize(to), stage);
        float milliseconds = 0;
        check(cudaEventElapsedTime(&milliseconds, from, to), stage);
        return 1e-3 * double(milliseconds);
    };
    const Clock before = store.clock();
    const std::vector<int> quiet = store.quiet.downloaded();
    const double sorting = timed("sort", [&] {
        order(views, needs, store.sort_space(), main);
        if (needs.rests) settle(views, main);
        arrange(views, needs, store.sort_space(), main);
    });
    begin(views, main);
    const double posing = timed("pose", [&] {
        if (needs.tools) masks(views, main), pose(views, main);
    });
    const double scatter = timed("p2g", [&] { p2g(views, needs, processors, main); });
    times = {{"sort", sorting}, {"pose", posing}, {"p2g", scatter}, {"grid", 0}, {"g2p", 0}};
    const auto under_way = [&] {
        Clock now = store.clock();
        return now.step(now.done).dt > 0;
    };
    int counted = 0;
    for (int k = 0; k < warm + repeats && under_way(); ++k) {
        const double step[] = {timed("grid", [&] { grid(views, needs, processors, main); }),
                               timed("g2p", [&] { g2p(views, needs, processors, main); })};
        if (k < warm && last_substeps > warm) continue;
        times[3].seconds += step[0], times[4].seconds += step[1], ++counted;
    }
    for (std::size_t s : {3, 4}) times[s].seconds *= double(last_substeps) / counted;
    store.clear_grids();
    if (needs.rests)
        check(cudaMemcpy(store.quiet.data(), quiet.data(), store.quiet.bytes(), cudaMemcpyDefault),
              "measure");
    Clock after = before;
    for (int& active : after.active) active = 0;
    store.set_clock(after);
    if (needs.tools) pose_end(views);
}

// Tools back to the end of the frame, for penetration().
void GpuSolver::pose_end(const Views& views) const
{
    const Clock after = store.clock();
    Clock clock = after;
    --clock.done;
    clock.step(clock.done) = {0, clock.duration, Limit::frame_end};
    store.set_clock(clock);
    pose(views, main);
    wait(main, "measure");
    store.set_clock(after);
}

}  // namespace knead::gpu
