// How much of the return map particles save that do not yield, by how many these are and whether
// they lie together.
#include "profiling/micro/yielding.cuh"

namespace knead::micro {
namespace {

constexpr int count = 1 << 20;

struct Share {
    unsigned yielding;  // of 1024 particles
    bool together;      // the first of all, or spread evenly
};

__device__ bool yields(unsigned i, const Share& share)
{
    if (share.together) return i < share.yielding * unsigned(count / 1024);
    return (scrambled(i) & 1023) < share.yielding;
}

// A trial strain of twice or half of what the clay bears, a little different in each step.
template <Elasticity elasticity>
__global__ void __launch_bounds__(threads) early_kernel(Share share, float2* out)
{
    const auto i = unsigned(blockIdx.x * threads + threadIdx.x);
    const Material<float> m = weak_clay(elasticity);
    const Mat3<float> L = stretch_of(i);
    const Sym3<float> unit = deviator(symmetric(L));
    const float bears = 0.8164966f * m.yield / (2 * m.mu) / sqrtf(norm_squared(unit));
    const float size = yields(i, share) ? 2 * bears : 0.5f * bears;
    float sum = 0;
    unsigned yielded = 0;
#pragma unroll 1
    for (int step = 0; step < steps; ++step) {
        Particle<float> q{};
        // b = (I + s L)^2 would be 2 s L; the volume is left alone but for the second order.
        q.e = (2 * size * (1 + 0.01f * float(step))) * unit;
        yielded += yield(q, m, 1.0f);
        sum += sqrtf(norm_squared(q.e));
    }
    out[i] = {sum, float(yielded)};
}

template <Elasticity elasticity>
void time_share(Bench& bench, const std::string& map, const std::string& share, const Share& how)
{
    DeviceArray<float2> out(count);
    must_not_spill("early", early_kernel<elasticity>);
    Row row{"early", map + ", " + share, "particle and step"};
    row.count = double(count) * steps;
    const auto launched = [&] {
        launch("early", early_kernel<elasticity>, count / threads, threads, bench.stream, how,
               out.data());
    };
    const auto right = [&] {
        double yielded = 0, sum = 0;
        for (const float2& r : out.downloaded()) yielded += double(r.y), sum += double(r.x);
        const double wanted = row.count * how.yielding / 1024;
        return std::fabs(yielded - wanted) < 0.02 * row.count && sum > 0 &&
               (how.yielding % 1024 || yielded == wanted);
    };
    bench.add(
        row, [] {}, launched, right);
}

template <Elasticity elasticity>
void time_map(Bench& bench, const std::string& map)
{
    time_share<elasticity>(bench, map, "none yields", {0, true});
    for (const bool together : {true, false}) {
        const std::string where = together ? " yields, together" : " yields, scattered";
        time_share<elasticity>(bench, map, "1 %" + where, {10, together});
        time_share<elasticity>(bench, map, "10 %" + where, {102, together});
    }
    time_share<elasticity>(bench, map, "all yield", {1024, true});
}

}  // namespace

void measure_early(Bench& bench)
{
    time_map<Elasticity::neo_hookean>(bench, "neo-Hookean");
    time_map<Elasticity::hencky>(bench, "Hencky by eigenvalues");
}

}  // namespace knead::micro
