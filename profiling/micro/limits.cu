// What bounds everything else: the clock, the rate of issue, a launch, a copy, an atomic.
#include "atomics.cuh"
#include "bench.cuh"
#include "host/bench_device.h"

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

__global__ void empty_kernel(int* touched) { *touched = 1; }

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
    row.most = bench.limits.issue(), row.limit = "issue";
    row.right = true;
    for (float x : out.downloaded()) row.right = row.right && x == 2;
    bench.rows.push_back(row);
}

void launches(Bench& bench)
{
    constexpr int kernels = 200;
    DeviceArray<int> touched(1);
    const auto row = [](const char* what) {
        Row r{"limits", what, "kernel"};
        r.count = kernels;
        return r;
    };
    const auto right = [&] { return touched.downloaded().at(0) == 1; };
    const auto all = [&] {
        for (int k = 0; k < kernels; ++k)
            launch("empty", empty_kernel, 1, 32, bench.stream, touched.data());
    };
    bench.add(
        row("empty kernels, one after the other"), [] {}, all, right);
    if (bench.once()) return;  // profilers take graphs apart
    cudaGraph_t graph;
    cudaGraphExec_t ready;
    check(cudaStreamBeginCapture(bench.stream, cudaStreamCaptureModeThreadLocal), "capture");
    all();
    check(cudaStreamEndCapture(bench.stream, &graph), "capture");
    check(cudaGraphInstantiate(&ready, graph, 0), "graph");
    bench.add(
        row("empty kernels, nodes of a graph"),
        [&] { check(cudaMemsetAsync(touched.data(), 0, touched.bytes(), bench.stream), "clear"); },
        [&] { check(cudaGraphLaunch(ready, bench.stream), "graph"); }, right);
    cudaGraphExecDestroy(ready);
    cudaGraphDestroy(graph);
}

}  // namespace

void measure_limits(Bench& bench)
{
    const DeviceFacts facts = gpu::facts_of(0);
    bench.limits.multiprocessors = facts.multiprocessors;
    bench.limits.copy = facts.copy;
    issue(bench);
    bench.limits.adds = most_adds(bench);
    launches(bench);
}

}  // namespace knead::micro
