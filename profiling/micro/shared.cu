// Additions to shared memory, by type and by how many lanes of a warp agree on the address.
#include "profiling/micro/bench.cuh"

namespace knead::micro {
namespace {

constexpr int blocks_each = 8;

// Every warp has 32 words; `agree` is log2 of how many lanes side by side add to one of them. `by`
// is 1, which the compiler must not know: it would count lanes instead.
template <class Number>
__global__ void __launch_bounds__(threads)
    atomic_kernel(Number* out, int agree, int turns, Number by)
{
    __shared__ Number words[threads];
    const int lane = int(threadIdx.x & 31), first = int(threadIdx.x) - lane;
    words[threadIdx.x] = 0;
    __syncwarp();
#pragma unroll 8
    for (int t = 0; t < turns; ++t) atomicAdd(words + first + (((lane >> agree) + t) & 31), by);
    __syncwarp();
    out[blockIdx.x * threads + threadIdx.x] = words[threadIdx.x];
}

// No atomic: no two lanes have one address in a turn, and a turn ends before the next begins.
__global__ void __launch_bounds__(threads) plain_kernel(float* out, int, int turns, float by)
{
    __shared__ float4 words[threads];
    const int lane = int(threadIdx.x & 31), first = int(threadIdx.x) - lane;
    words[threadIdx.x] = {0, 0, 0, 0};
    __syncwarp();
#pragma unroll 8
    for (int t = 0; t < turns; ++t) {
        float4& to = words[first + ((lane + t) & 31)];
        const float4 a = to;
        to = {a.x + by, a.y + by, a.z + by, a.w + by};
        __syncwarp();
    }
    const float4 a = words[threadIdx.x];
    out[blockIdx.x * threads + threadIdx.x] = 0.25f * (a.x + a.y + a.z + a.w);
}

template <class Number>
void time_form(Bench& bench, const char* type, void (*kernel)(Number*, int, int, Number), int agree)
{
    constexpr int turns = 512;
    const int blocks = blocks_each * bench.limits.multiprocessors;
    DeviceArray<Number> out(std::size_t(blocks) * threads);
    must_not_spill("shared", kernel);
    Row row{"shared", std::string(type) + ", " + std::to_string(1 << agree) + " equal",
            "addition by a lane"};
    row.count = double(blocks) * threads * turns;
    // A bank serves one word a cycle.
    const double words = double(sizeof(Number)) / 4;
    row.max = 32.0 / words * bench.limits.multiprocessors * bench.limits.clock;
    row.limit = "banks";
    bench.add(
        row, [] {},
        [&] {
            launch("shared", kernel, blocks, threads, bench.stream, out.data(), agree, turns,
                   Number(1));
        },
        [&] {
            double sum = 0;
            for (Number n : out.downloaded()) sum += double(n);
            return sum == row.count;
        });
}

}  // namespace

void measure_shared(Bench& bench)
{
    for (int agree : {0, 1, 2, 3, 5}) time_form(bench, "int32 atomic", atomic_kernel<int>, agree);
    for (int agree : {0, 1, 2, 3, 5}) time_form(bench, "float atomic", atomic_kernel<float>, agree);
    for (int agree : {0, 3})
        time_form(bench, "64-bit integer atomic", atomic_kernel<unsigned long long>, agree);
    time_form(bench, "float4 read, added, written: no atomic", plain_kernel, 0);
    Row& row = bench.rows.back();
    row.max /= 8;  // four words there and back
}

}  // namespace knead::micro
