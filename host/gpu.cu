// The device behind Solver. A frame is one graph: orders in, sort, then substeps for as long as the
// device finds time left in the frame; the host waits for nothing but the counters.
#include <bit>
#include <cstdlib>

#include "cuda/surface.cuh"
#include "gpu_store.cuh"
#include "pieces.h"
#include "solver.h"

namespace knead {
namespace gpu {
namespace {

// Going round the graph's loop costs about 3 us, and a substep that finds the frame over about 4.
constexpr int substeps_a_turn = 4;

struct Stream {
    cudaStream_t s = nullptr;
    Stream() { check(cudaStreamCreateWithFlags(&s, cudaStreamNonBlocking), "stream"); }
    Stream(const Stream&) = delete;
    ~Stream() { cudaStreamDestroy(s); }
    operator cudaStream_t() const { return s; }
};

struct Event {
    cudaEvent_t e = nullptr;
    explicit Event(unsigned flags = cudaEventDefault)
    {
        check(cudaEventCreateWithFlags(&e, flags), "event");
    }
    Event(const Event&) = delete;
    ~Event() { cudaEventDestroy(e); }
    operator cudaEvent_t() const { return e; }
};

struct FrameGraph {
    cudaGraph_t graph = nullptr;
    cudaGraphExec_t ready = nullptr;
    FrameGraph() = default;
    FrameGraph(const FrameGraph&) = delete;
    ~FrameGraph()
    {
        if (ready) cudaGraphExecDestroy(ready);
        if (graph) cudaGraphDestroy(graph);
    }
};

int multiprocessors(int device)
{
    int n = 0;
    check(cudaDeviceGetAttribute(&n, cudaDevAttrMultiProcessorCount, device), "device");
    return n;
}

// A node that runs its body again and again until the device says otherwise; the body.
cudaGraph_t add_while(cudaStream_t captured, cudaGraphConditionalHandle handle)
{
    cudaStreamCaptureStatus status;
    cudaGraph_t graph;
    const cudaGraphNode_t* before;
    std::size_t count;
    cudaGraphNodeParams params{};
    params.type = cudaGraphNodeTypeConditional;
    params.conditional.handle = handle;
    params.conditional.type = cudaGraphCondTypeWhile;
    params.conditional.size = 1;
    cudaGraphNode_t node;
#if CUDART_VERSION >= 13000
    check(cudaStreamGetCaptureInfo(captured, &status, nullptr, &graph, &before, nullptr, &count),
          "capture");
    check(cudaGraphAddNode(&node, graph, before, nullptr, count, &params), "while node");
    check(cudaStreamUpdateCaptureDependencies(captured, &node, nullptr, 1,
                                              cudaStreamSetCaptureDependencies),
          "capture");
#else
    check(cudaStreamGetCaptureInfo_v2(captured, &status, nullptr, &graph, &before, &count),
          "capture");
    check(cudaGraphAddNode(&node, graph, before, count, &params), "while node");
    check(cudaStreamUpdateCaptureDependencies(captured, &node, 1, cudaStreamSetCaptureDependencies),
          "capture");
#endif
    return params.conditional.phGraph_out[0];
}

class GpuSolver : public Solver {
  public:
    GpuSolver(const Setup& given, int device);
    Tally advance(const Motion& motion, double duration) override;
    std::vector<Particle<double>> particles() const override;
    std::vector<double> penetration() const override;
    const std::vector<StageTime>& stage_times() const override;
    const Clay* clay() const override { return &held; }
    std::size_t memory() const override { return store.bytes(); }
    std::string name() const override { return title; }

  private:
    void capture(FrameGraph& to, bool tools);
    void start(const Views& views, const Needs& needs);
    void substep(const Views& views, const Needs& needs, cudaStream_t stream);
    Views views_for(const Needs& needs) const;
    void step_through();
    void measure() const;
    void pose_end(const Views& views) const;
    void settle_cuts(const Motion& motion, double duration, bool covered);

    Setup rules;  // without particles
    int device, processors;
    Store store;
    Clay held;
    std::string title;
    Stream main, body, beside;
    Event forked{cudaEventDisableTiming}, joined{cudaEventDisableTiming};
    FrameGraph with_tools, without_tools;
    Pinned<Clock> status;
    bool posed = false;        // masks are those of the last frame's end
    bool stepwise = false;     // no graph: KNEAD_GRAPH=0, for profilers and memory checkers
    bool cutting = false;      // a tool of the scene is a blade
    bool was_covered = false;  // a blade was in the clay at the end of the last frame
    int last_substeps = 0;
    mutable std::vector<StageTime> times;
};

int chosen(int device)
{
    int count = 0;
    if (cudaGetDeviceCount(&count) != cudaSuccess || count == 0)
        throw std::runtime_error("no CUDA device");
    if (device < 0 || device >= count)
        throw std::runtime_error("no CUDA device " + std::to_string(device) + " among " +
                                 std::to_string(count));
    check(cudaSetDevice(device), "device");
    return device;
}

GpuSolver::GpuSolver(const Setup& given, int wanted)
    : rules(given),
      device(chosen(wanted)),
      processors(multiprocessors(device)),
      store(given),
      held{{store.views().particles[0], store.views().particles[1]}, &store.views().clock->side}
{
    rules.particles.clear();
    rules.particles.shrink_to_fit();
    cudaDeviceProp properties;
    check(cudaGetDeviceProperties(&properties, device), "device");
    title = std::string("cuda: ") + properties.name;
    cutting = store.needs().blades;
    const char* graph = std::getenv("KNEAD_GRAPH");
    stepwise = graph && std::string(graph) == "0";
    if (stepwise) return;
    capture(without_tools, false);
    if (store.needs().tools) capture(with_tools, true);
}

Views GpuSolver::views_for(const Needs& needs) const
{
    Views views = store.views();
    if (!needs.tools) views.tools.primitives.count = views.tools.passes = 0;
    return views;
}

// What comes before the first grid update. Posing the tools needs nothing of the particles, so it
// runs beside the sort.
void GpuSolver::start(const Views& views, const Needs& needs)
{
    store.send_orders(main);
    begin(views, main);
    if (needs.tools) {
        check(cudaEventRecord(forked, main), "fork");
        check(cudaStreamWaitEvent(beside, forked, 0), "fork");
        masks(views, beside);
        pose(views, beside);
        check(cudaEventRecord(joined, beside), "join");
    }
    order(views, needs, store.sort_space(), main);
    if (needs.tools) check(cudaStreamWaitEvent(main, joined, 0), "join");
    if (needs.rests) settle(views, main);
    arrange(views, needs, store.sort_space(), main);
    p2g(views, needs, processors, main);
}

void GpuSolver::substep(const Views& views, const Needs& needs, cudaStream_t stream)
{
    grid(views, needs, processors, stream);
    g2p(views, needs, processors, stream);
}

void GpuSolver::capture(FrameGraph& to, bool tools)
{
    Needs needs = store.needs();
    needs.tools = tools || needs.blades;  // a cut stays one when the hands have gone
    Views views = views_for(needs);
    check(cudaStreamBeginCapture(main, cudaStreamCaptureModeThreadLocal), "capture");
    start(views, needs);
    cudaStreamCaptureStatus state;
    cudaGraph_t graph;
#if CUDART_VERSION >= 13000
    check(cudaStreamGetCaptureInfo(main, &state, nullptr, &graph, nullptr, nullptr, nullptr),
          "capture");
#else
    check(cudaStreamGetCaptureInfo_v2(main, &state, nullptr, &graph, nullptr, nullptr), "capture");
#endif
    check(cudaGraphConditionalHandleCreate(&views.again, graph, 1, cudaGraphCondAssignDefault),
          "while node");
    views.looped = true;
    const cudaGraph_t loop = add_while(main, views.again);
    check(cudaStreamBeginCaptureToGraph(body, loop, nullptr, nullptr, 0,
                                        cudaStreamCaptureModeThreadLocal),
          "capture");
    for (int k = 0; k < substeps_a_turn; ++k) substep(views, needs, body);
    cudaGraph_t same;
    check(cudaStreamEndCapture(body, &same), "capture");
    check(cudaMemcpyAsync(status.data(), views.clock, sizeof(Clock), cudaMemcpyDeviceToHost, main),
          "status");
    check(cudaStreamEndCapture(main, &to.graph), "capture");
    check(cudaGraphInstantiate(&to.ready, to.graph, 0), "graph");
    check(cudaGraphUpload(to.ready, main), "graph");
    check(cudaStreamSynchronize(main), "graph");
}

// The frame without its graph, the host asking after each substep whether there is another.
void GpuSolver::step_through()
{
    Needs needs = store.needs();
    needs.tools = posed || needs.blades;
    const Views views = views_for(needs);
    start(views, needs);
    do {
        substep(views, needs, main);
        check(cudaMemcpyAsync(status.data(), views.clock, sizeof(Clock), cudaMemcpyDeviceToHost,
                              main),
              "status");
        check(cudaStreamSynchronize(main), "substep");
    } while (status->step(status->done).dt > 0);
}

Tally GpuSolver::advance(const Motion& motion, double duration)
{
    Tally tally;
    if (!(duration > 0)) return tally;
    check(cudaSetDevice(device), "device");
    store.order(rules, motion, duration);
    const ProfilerRange range{"substeps"};
    posed = store.tools_active();
    if (stepwise)
        step_through();
    else
        check(cudaGraphLaunch(posed ? with_tools.ready : without_tools.ready, main), "substeps");
    check(cudaStreamSynchronize(main), "substeps");
    const Counters& n = status->counters;
    tally.substeps = last_substeps = n.substeps;
    tally.dt_least = n.dt_least, tally.dt_most = n.dt_most;
    for (int l = 0; l < int(Limit::count); ++l) tally.limits[l] = n.limits[l];
    tally.yielded = long(n.yielded), tally.projected = long(n.projected);
    tally.clipped = long(n.clipped), tally.confined = long(n.confined);
    tally.repaired = long(n.repaired);
    tally.found_depth = double(std::bit_cast<float>(n.deepest));
    tally.active_blocks = n.active_blocks;
    tally.moved =
        store.needs().rests ? long(n.moved) : long(store.views().particles[0].count) * n.substeps;
    tally.woken = long(n.woken);
    times.clear();
    if (cutting) settle_cuts(motion, duration, n.covered > 0);
    return tally;
}

// Rare, and of the whole scene at once: done by the host.
void GpuSolver::settle_cuts(const Motion& motion, double duration, bool covered)
{
    if (covered == was_covered) return;
    PosedTools<double> tools(rules, rules.lattice);
    tools.activate(motion);
    tools.pose(motion, 0, 1, duration);
    tools.mask_blocks(rules.lattice);
    std::vector<Particle<double>> q = store.particles();
    if (settle(q, rules.lattice, tools, covered, was_covered)) store.set_sides(q);
    was_covered = covered;
}

std::vector<Particle<double>> GpuSolver::particles() const
{
    check(cudaSetDevice(device), "device");
    return store.particles();
}

std::vector<double> GpuSolver::penetration() const
{
    std::vector<double> depths;
    if (!posed) return depths;
    check(cudaSetDevice(device), "device");
    gpu::penetration(store.views(), store.depth.data(), main);
    check(cudaStreamSynchronize(main), "penetration");
    for (float d : store.depth.downloaded())
        if (d > 0) depths.push_back(double(d));
    return depths;
}

// Asking is measuring: a few substeps are run stage by stage from where the last frame ended, and
// undone. Shares of one frame of the graph, in which stages overlap.
const std::vector<StageTime>& GpuSolver::stage_times() const
{
    if (times.empty() && last_substeps > 0) measure();
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
    const auto copy_rows = [&](int source, int target) {
        const std::size_t bytes = store.rows[0].bytes();
        check(cudaMemcpy(views.particles[target].rows, views.particles[source].rows, bytes,
                         cudaMemcpyDefault),
              "measure");
        check(cudaDeviceSynchronize(), "measure");
    };
    const std::vector<int> quiet = store.quiet.downloaded();
    const double sorting = timed("sort", [&] {
        order(views, needs, store.sort_space(), main);
        if (needs.rests) settle(views, main);
        arrange(views, needs, store.sort_space(), main);
    });
    const Clock before = store.clock();
    copy_rows(before.side, before.side ^ 1);
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
    copy_rows(before.side ^ 1, before.side);
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
    check(cudaStreamSynchronize(main), "measure");
    store.set_clock(after);
}

}  // namespace
}  // namespace gpu

std::unique_ptr<Solver> gpu_solver(const Setup& setup, int device)
{
    return std::make_unique<gpu::GpuSolver>(setup, device);
}

bool gpu_present()
{
    int count = 0;
    return cudaGetDeviceCount(&count) == cudaSuccess && count > 0;
}

}  // namespace knead
