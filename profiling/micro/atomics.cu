#include "profiling/micro/atomics.cuh"

namespace knead::micro {
namespace {

constexpr int adding_threads = 256, adds_each = 32;

enum class Form { vector, floats, one_float, integers };
enum class To { neighbours, anywhere, one };

// Nodes: float4, or four long long. `mask` is how many less one, of a power of two.
struct Target {
    void* nodes;
    unsigned mask;
    int agree;   // log2 of how many lanes side by side add to one node
    int groups;  // of lanes, in all
};

template <Form form>
__device__ void add_one(void* nodes, unsigned at)
{
    if constexpr (form == Form::vector) {
        add(static_cast<float4*>(nodes) + at, {1, 2, 3, 4});
    } else if constexpr (form == Form::floats) {
        float* to = static_cast<float*>(nodes) + 4 * std::size_t(at);
        UNROLL
        for (int k = 0; k < 4; ++k) atomicAdd(to + k, float(k + 1));
    } else if constexpr (form == Form::one_float) {
        atomicAdd(static_cast<float*>(nodes) + 4 * std::size_t(at), 1.0f);
    } else {
        auto* to = static_cast<unsigned long long*>(nodes) + 4 * std::size_t(at);
        UNROLL
        for (int k = 0; k < 4; ++k) atomicAdd(to + k, static_cast<unsigned long long>(k + 1));
    }
}

template <Form form, To where>
__global__ void __launch_bounds__(adding_threads) add_kernel(Target t)
{
    const unsigned group = (blockIdx.x * adding_threads + threadIdx.x) >> t.agree;
    for (unsigned k = 0; k < adds_each; ++k) {
        const unsigned n = group + k * unsigned(t.groups);
        const unsigned at = where == To::one          ? 0
                            : where == To::neighbours ? n & t.mask
                                                      : scrambled(n) & t.mask;
        add_one<form>(t.nodes, at);
    }
}

// The sum of the first of each node's four numbers and whether the others are 2, 3, 4 times it.
template <class Number>
double total(const DeviceArray<Number>& nodes, bool all_four)
{
    double sum[4] = {};
    const std::vector<Number> host = nodes.downloaded();
    for (std::size_t i = 0; i < host.size(); ++i) sum[i & 3] += double(host[i]);
    for (int k = 1; k < 4; ++k)
        if (sum[k] != (all_four ? (k + 1) * sum[0] : 0)) return -1;
    return sum[0];
}

struct Case {
    const char* what;
    int lanes, agree, nodes;  // agree and nodes: log2
};

template <Form form, To where>
void time_case(Bench& bench, const Case& c)
{
    using Number = std::conditional_t<form == Form::integers, long long, float>;
    DeviceArray<Number> nodes(std::size_t(4) << c.nodes);
    const Target target{nodes.data(), (1u << c.nodes) - 1, c.agree, c.lanes >> c.agree};
    must_not_spill("atomics", add_kernel<form, where>);
    Row row{"atomics", c.what, "addition by a lane"};
    row.count = double(c.lanes) * adds_each;
    row.max = bench.limits.adds, row.limit = "atomics";
    bench.add(
        row, [&] { check(cudaMemsetAsync(nodes.data(), 0, nodes.bytes(), bench.stream), "clear"); },
        [&] {
            launch("atomics", add_kernel<form, where>, c.lanes / adding_threads, adding_threads,
                   bench.stream, target);
        },
        [&] { return total(nodes, form != Form::one_float) == row.count; });
}

// Nodes are so many that a node's sum stays below 2^24, where floats count.
constexpr int lanes = 1 << 20, lattice = 18;

}  // namespace

double max_adds(Bench& bench)
{
    time_case<Form::vector, To::neighbours>(bench,
                                            {"float4, neighbouring nodes", lanes, 0, lattice});
    Row& row = bench.rows.back();
    row.question = "limits";
    return row.seconds > 0 ? row.count / row.seconds : 0;
}

void measure_atomics(Bench& bench)
{
    using enum Form;
    time_case<vector, To::neighbours>(bench,
                                      {"float4, neighbouring nodes of 64^3", lanes, 0, lattice});
    time_case<vector, To::anywhere>(bench, {"float4, any node of 64^3", lanes, 0, lattice});
    time_case<vector, To::anywhere>(bench, {"float4, any node of 256 MiB", lanes, 0, 24});
    const char* agreeing[] = {
        "float4, neighbours, 2 lanes a node", "float4, neighbours, 4 lanes a node",
        "float4, neighbours, 8 lanes a node", "float4, neighbours, 16 lanes a node",
        "float4, neighbours, 32 lanes a node"};
    for (int k = 0; k < 5; ++k)
        time_case<vector, To::neighbours>(bench, {agreeing[k], lanes, k + 1, lattice});
    time_case<vector, To::anywhere>(bench, {"float4, any node, 8 lanes a node", lanes, 3, lattice});
    time_case<vector, To::one>(bench, {"float4, all to one node", 1 << 16, 0, 8});
    time_case<floats, To::neighbours>(bench, {"4 floats, neighbouring nodes", lanes, 0, lattice});
    time_case<floats, To::anywhere>(bench, {"4 floats, any node", lanes, 0, lattice});
    time_case<one_float, To::neighbours>(bench,
                                         {"1 float of 4, neighbouring nodes", lanes, 0, lattice});
    time_case<integers, To::neighbours>(
        bench, {"4 integers of 64 bits, neighbouring nodes", lanes, 0, lattice});
    time_case<integers, To::anywhere>(bench,
                                      {"4 integers of 64 bits, any node", lanes, 0, lattice});
}

}  // namespace knead::micro
