// What bounds everything else: the clock, the rate of issue, a launch, a copy, an atomic.
#include "cuda/device/graph.cuh"
#include "host/bench/device.h"
#include "profiling/micro/atomics.cuh"
#include "profiling/micro/bench.cuh"

namespace knead::micro {
namespace {

constexpr int issue_threads = 512, chains = 8, unrolled = 64;

// Multiply-adds and nothing else; x comes to rest at b / (1 - a).
__global__ void __launch_bounds__(issue_threads)
    issue_kernel(float* out, long long* cycles, float a, float b, int turns)
{
    float x[chains];
    UNROLL
    for (int k = 0; k < chains; ++k) x[k] = float(k);
    const long long from = clock64();
    for (int t = 0; t < turns; ++t) {
        UNROLL
        for (int k = 0; k < unrolled; ++k) x[k % chains] = fmaf(x[k % chains], a, b);
    }
    float sum = 0;
    UNROLL
    for (int k = 0; k < chains; ++k) sum += x[k];
    out[blockIdx.x * issue_threads + threadIdx.x] = sum / chains;
    if (threadIdx.x == 0) cycles[blockIdx.x] = clock64() - from;
}

__global__ void empty_kernel(int* occupied) { *occupied = 1; }
__global__ void decide_kernel(cudaGraphConditionalHandle met, bool yes)
{
    cudaGraphSetConditional(met, yes);
}
__global__ void turn_kernel(cudaGraphConditionalHandle again, int* turns, int max)
{
    cudaGraphSetConditional(again, ++*turns % max != 0);
}

// The clock from how two runs of different length differ, so that starting them cancels.
void issue(Bench& bench)
{
    const int blocks = bench.limits.multiprocessors, turns = 4000;
    DeviceArray<float> out(std::size_t(blocks) * issue_threads);
    DeviceArray<long long> cycles{std::size_t(blocks)};
    must_not_spill("issue", issue_kernel);
    long long took[2] = {};
    double seconds[2] = {};
    for (int k = 0; k < 2; ++k) {
        seconds[k] = bench.seconds(
            k ? "limits/long" : "limits/short", [] {},
            [&] {
                launch("issue", issue_kernel, blocks, issue_threads, bench.stream, out.data(),
                       cycles.data(), 0.5f, 1.0f, turns << k);
            });
        took[k] = cycles.downloaded().at(0);
    }
    if (!bench.once()) bench.limits.clock = double(took[1] - took[0]) / (seconds[1] - seconds[0]);
    Row row{"limits", "multiply-adds, 16 warps a multiprocessor", "warp instruction"};
    row.count = double(blocks) * (issue_threads / 32) * unrolled * turns;
    row.seconds = seconds[1] - seconds[0];
    row.max = bench.limits.issue(), row.limit = "issue";
    row.right = true;
    for (float x : out.downloaded()) row.right = row.right && x == 2;
    bench.rows.push_back(row);
}

// Launches and conditions, on the stream and as nodes of graphs.
class Launches {
  public:
    explicit Launches(Bench& on) : bench(on) {}

    void on_the_stream()
    {
        add(
            "empty kernels, one after the other", [this] { launch_all(); }, 1);
    }
    void in_a_graph()
    {
        replay(
            "empty kernels, nodes of a graph", [this] { launch_all(); }, 1);
    }
    void with_conditions(bool met)
    {
        const auto record = [this, met] {
            for (int k = 0; k < nodes; ++k) {
                const auto handle = condition();
                launch("decide", decide_kernel, 1, 1, bench.stream, handle, met);
                gpu::capture_body(gpu::add_conditional(bench.stream, cudaGraphCondTypeIf, handle),
                                  body, [this](cudaStream_t stream) { touch(stream); });
            }
        };
        replay(met ? "… each with a kernel under a condition that is met"
                   : "… each with a kernel under a condition that is not met",
               record, met);
    }
    void turns_of_a_loop()
    {
        const auto record = [this] {
            const auto handle = condition();
            gpu::capture_body(gpu::add_conditional(bench.stream, cudaGraphCondTypeWhile, handle),
                              body, [this, handle](cudaStream_t stream) {
                                  launch("turn", turn_kernel, 1, 1, stream, handle, occupied.data(),
                                         nodes);
                              });
        };
        replay("turns of a graph's loop, a kernel each", record, nodes);
    }

  private:
    static constexpr int nodes = 200;
    Bench& bench;
    gpu::Stream body;
    DeviceArray<int> occupied{1};

    void touch(cudaStream_t stream)
    {
        launch("empty", empty_kernel, 1, 32, stream, occupied.data());
    }
    void launch_all()
    {
        for (int k = 0; k < nodes; ++k) touch(bench.stream);
    }
    cudaGraphConditionalHandle condition()
    {
        cudaGraphConditionalHandle handle;
        check(cudaGraphConditionalHandleCreate(&handle, gpu::under_capture(bench.stream), 1,
                                               cudaGraphCondAssignDefault),
              "condition");
        return handle;
    }
    template <class Record>
    void replay(const char* what, Record&& record, int expected)
    {
        gpu::Graph graph;
        graph.begin(bench.stream);
        record();
        graph.end(bench.stream);
        add(
            what, [&] { check(cudaGraphLaunch(graph.ready, bench.stream), "graph"); }, expected);
    }
    template <class Run>
    void add(const char* what, Run&& run, int expected)
    {
        Row row{"limits", what, "kernel"};
        row.count = nodes;
        const auto clear = [this] {
            check(cudaMemsetAsync(occupied.data(), 0, occupied.bytes(), bench.stream), "clear");
        };
        bench.add(row, clear, run, [&] { return occupied.downloaded().at(0) == expected; });
    }
};

void launches(Bench& bench)
{
    Launches all(bench);
    all.on_the_stream();
    if (bench.once()) return;  // profilers take graphs apart
    all.in_a_graph();
    all.with_conditions(false);
    all.with_conditions(true);
    all.turns_of_a_loop();
}

}  // namespace

void measure_limits(Bench& bench)
{
    const DeviceInfo facts = gpu::facts_of(0);
    bench.limits.multiprocessors = facts.multiprocessors;
    bench.limits.copy = facts.copy;
    issue(bench);
    bench.limits.adds = max_adds(bench);
    launches(bench);
}

}  // namespace knead::micro
