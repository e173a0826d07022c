#include "profiling/micro/bench.cuh"

namespace knead::micro {

__global__ void hold_kernel(long long cycles)
{
    const long long from = clock64();
    while (clock64() - from < cycles) {
    }
}

__global__ void mark_kernel() {}

Bench::Bench(const Settings& s) : settings(s)
{
    check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "stream");
    if (!once()) return;
    names.open(settings.once);
    if (!names) throw std::runtime_error("cannot write " + settings.once);
}

Bench::~Bench() { cudaStreamDestroy(stream); }

double Bench::seconds(const std::string& name, const std::function<void()>& prepare,
                      const std::function<void()>& run)
{
    if (once()) {
        prepare();
        check(cudaStreamSynchronize(stream), name.c_str());
        launch("mark", mark_kernel, 1, 1, stream);
        const gpu::ProfilerRange range{name.c_str()};
        run();
        launch("mark", mark_kernel, 1, 1, stream);
        names << name << std::endl;
        check(cudaStreamSynchronize(stream), name.c_str());
        return 0;
    }
    constexpr int warm = 3;
    std::vector<float> times;
    cudaEvent_t from, to;
    check(cudaEventCreate(&from), "event");
    check(cudaEventCreate(&to), "event");
    for (int k = 0; k < warm + settings.repeats; ++k) {
        prepare();
        launch("hold", hold_kernel, 1, 1, stream, 200000ll);
        check(cudaEventRecord(from, stream), "event");
        run();
        check(cudaEventRecord(to, stream), "event");
        check(cudaEventSynchronize(to), name.c_str());
        float milliseconds = 0;
        check(cudaEventElapsedTime(&milliseconds, from, to), name.c_str());
        if (k >= warm) times.push_back(milliseconds);
    }
    cudaEventDestroy(from);
    cudaEventDestroy(to);
    std::sort(times.begin(), times.end());
    return 1e-3 * double(times[times.size() / 2]);
}

void Bench::add(Row row, const std::function<void()>& prepare, const std::function<void()>& run,
                const std::function<bool()>& right)
{
    row.seconds = seconds(name_of(row), prepare, run);
    if (row.max == 0) row.limit = "issue";
    row.right = right();
    rows.push_back(std::move(row));
}

std::vector<Row> measured(const Settings& settings, Limits& limits)
{
    Bench bench(settings);
    const auto ask = [&](const char* question, void (*measure)(Bench&)) {
        if (bench.wanted(question)) measure(bench);
    };
    measure_limits(bench);  // every share is of what it finds
    ask("atomics", measure_atomics);
    ask("shared", measure_shared);
    ask("merge", measure_merge);
    ask("order", measure_order);
    ask("transfer", measure_transfer);
    ask("return", measure_return);
    ask("early", measure_early);
    ask("rebin", measure_rebin);
    limits = bench.limits;
    if (!bench.wanted("limits"))
        std::erase_if(bench.rows, [](const Row& r) { return r.question == "limits"; });
    return bench.rows;
}

}  // namespace knead::micro
