// Time and hardware counters of each stage of a frame.
#include <utility>

#include "host/solver/gpu/solver.cuh"

namespace knead::gpu {
namespace {

constexpr int warm = 2, repeats = 10;  // substeps

// Extrapolates samples of each stage to a whole frame. Stages of a substep are sampled in a few
// substeps, of which the first are dropped (cold caches).
template <class Amount>
std::vector<std::pair<std::string, Amount>> of_a_frame(
    const std::vector<std::pair<std::string, Amount>>& seen, int substeps)
{
    std::vector<std::pair<std::string, Amount>> all;
    for (const auto& [stage, every] : {std::pair{"sort", 0},
                                       {"pose", 0},
                                       {"p2g", 0},
                                       {"separate", 1},
                                       {"grid", 1},
                                       {"g2p", 1},
                                       {"deform", follow_every}}) {
        std::vector<Amount> own;
        for (const auto& [name, amount] : seen)
            if (name == stage) own.push_back(amount);
        if (own.empty()) continue;
        const int cold = every ? (warm + every - 1) / every : 0;
        if (int(own.size()) > cold) own.erase(own.begin(), own.begin() + cold);
        Amount sum{};
        for (const Amount& amount : own) sum += amount;
        const int times = every ? (substeps + every - 1) / every : int(own.size());
        all.push_back({stage, double(times) / double(own.size()) * sum});
    }
    return all;
}

}  // namespace

const std::vector<StageTime>& GpuSolver::times() const
{
    if (!stage_times.empty() || last_substeps == 0) return stage_times;
    Event from, to;
    std::vector<std::pair<std::string, double>> seen;
    walk([&](const char* stage, const std::function<void()>& run) {
        check(cudaEventRecord(from, main), stage);
        run();
        check(cudaEventRecord(to, main), stage);
        check(cudaEventSynchronize(to), stage);
        float milliseconds = 0;
        check(cudaEventElapsedTime(&milliseconds, from, to), stage);
        seen.push_back({stage, 1e-3 * double(milliseconds)});
    });
    for (const auto& [name, seconds] : of_a_frame(seen, last_substeps))
        stage_times.push_back({name, seconds});
    return stage_times;
}

std::vector<StageWork> GpuSolver::counts() const
{
    std::vector<StageWork> all;
    if (last_substeps == 0) return all;
    check(cudaSetDevice(device), "device");
    std::vector<std::pair<std::string, DeviceWork>> seen;
    for (const StageWork& each : counted([&](const StageObserver& watch) {
             walk([&](const char* stage, const std::function<void()>& run) {
                 watch(stage, [&] { run(), wait(main, stage); });
             });
         }))
        seen.push_back({each.name, each.work});
    for (const auto& [name, amount] : of_a_frame(seen, last_substeps))
        all.push_back({name, amount});
    return all;
}

// Runs a few substeps stage by stage from the end of the last frame, without overlap, then restores
// the state from a copy. Runs fewer if clay comes near the end of the stored nodes.
void GpuSolver::walk(const StageObserver& watch) const
{
    wait(main, "measure");
    check(cudaSetDevice(device), "device");
    const Features features = features_for(posed);
    const Views views = views_for(features, posed ? ToolPace::slow : ToolPace::none);
    const Clock before = store.clock();
    const std::shared_ptr<DeviceState> kept = store.state(before.side, main);
    const std::shared_ptr<GaussianState> kept_splats = splats.state(store.snapshot_pool(), main);
    watch("sort", [&] { sort(views, features, main, before.side); });
    begin(views, main);
    if (features.tools)
        watch("pose",
              [&] { masks(views, main), line_up(views, features, main), pose(views, main); });
    watch("p2g", [&] {
        if (features.mean_pressure) find_pressures(views, main);
        p2g(views, features, processors, main);
    });
    const auto under_way = [&] {
        Clock now = store.clock();
        return now.step(now.done).dt > 0;
    };
    const auto deforms = [&](bool at_end) {
        if (features.splats) watch("deform", [&] { follow(views, features, at_end, main); });
    };
    int k = 0;
    for (; k < warm + repeats && under_way(); ++k) {
        if (features.bodies)
            watch("separate", [&] { separate(views, features, processors, main); });
        watch("grid", [&] { grid(views, features, processors, main); });
        if (k % follow_every == follow_every - 1) deforms(false);
        watch("g2p", [&] {
            if (features.mean_pressure) clear_pressures(views, processors, main);
            g2p(views, features, processors, main);
        });
    }
    if (k < follow_every) deforms(true);
    store.clear_grids();
    store.put_back(*kept, before.side, main);
    splats.copy_back(*kept_splats, main);
    wait(main, "measure");
    Clock after = before;
    for (int& active : after.active) active = 0;
    store.set_clock(after);
    if (features.tools) pose_end(views);
}

// Poses the tools at the end of the frame, for penetration().
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
