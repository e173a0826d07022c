// One number per lane of a vector register. Replaces R in the branch-free formulas of cuda/*.h, so
// that one call computes all lanes.
#pragma once
#include <cmath>
#include <cstring>
#include <utility>

#include "cuda/mpm/material.h"
#include "host/solver/cpu/namespace.h"

namespace knead {
inline namespace KNEAD_CPU_LEVEL {

#if defined __AVX512F__
constexpr int vector_bytes = 64;
#elif defined __AVX__
constexpr int vector_bytes = 32;
#else
constexpr int vector_bytes = 16;
#endif

template <class R>
struct Register;
template <>
struct Register<float> {
    typedef float V __attribute__((vector_size(vector_bytes)));
};
template <>
struct Register<double> {
    typedef double V __attribute__((vector_size(vector_bytes < 32 ? 32 : vector_bytes)));
};

template <class R>
struct Lanes {
    using V = typename Register<R>::V;
    static constexpr int count = sizeof(V) / sizeof(R);
    V v;

    Lanes() = default;
    Lanes(V all) : v(all) {}
    Lanes(R each) : v(each - V{}) {}
    R operator[](int lane) const { return v[lane]; }

    friend Lanes operator+(Lanes a, Lanes b) { return a.v + b.v; }
    friend Lanes operator-(Lanes a, Lanes b) { return a.v - b.v; }
    friend Lanes operator*(Lanes a, Lanes b) { return a.v * b.v; }
    friend Lanes operator/(Lanes a, Lanes b) { return a.v / b.v; }
    friend Lanes operator-(Lanes a) { return -a.v; }
    friend auto operator<(Lanes a, Lanes b) { return a.v < b.v; }  // per lane: 0 or -1
    // True if all lanes are equal.
    friend bool operator==(Lanes a, Lanes b)
    {
        const auto unequal = a.v != b.v;
        int any = 0;
        for (int l = 0; l < count; ++l) any |= unequal[l] != 0;
        return !any;
    }
};

template <class R>
inline Lanes<R> min(Lanes<R> a, Lanes<R> b)
{
    return b.v < a.v ? b.v : a.v;
}
template <class R>
inline Lanes<R> max(Lanes<R> a, Lanes<R> b)
{
    return a.v < b.v ? b.v : a.v;
}

// ln(1 + x) for x > -1, to 3 units in the last place: 1 + x = 2^n (1 + y) with 1 + y between the
// roots of 1/2 and 2, and ln(1 + y) = 2 artanh(y / (2 + y)) by its series.
template <class R>
inline Lanes<R> log_of_one_plus(Lanes<R> x)
{
    using V = typename Lanes<R>::V;
    using Bits = decltype(V{} < V{});
    constexpr int digits = sizeof(R) == 4 ? 23 : 52, terms = sizeof(R) == 4 ? 5 : 11;
    const V one = 1 - V{}, lowest = R(0.70710678118654752) - V{}, u = x.v + one;
    const V lost = x.v - (u - one);  // rounding error of 1 + x
    Bits bits, bits_lowest, bits_one;
    std::memcpy(&bits, &u, sizeof u), std::memcpy(&bits_lowest, &lowest, sizeof u);
    std::memcpy(&bits_one, &one, sizeof u);
    const Bits n = (bits - bits_lowest) >> digits, shift = n << digits;
    const Bits reduced = bits - shift, inverse = bits_one - shift;  // u / 2^n, 1 / 2^n
    V m, scale;
    std::memcpy(&m, &reduced, sizeof m), std::memcpy(&scale, &inverse, sizeof m);
    const V y = (m - one) + lost * scale, s = y / (2 + y), z = s * s;
    V sum = R(2) / (2 * terms - 1) - V{};
    for (int k = terms - 2; k > 0; --k) sum = sum * z + R(2) / R(2 * k + 1);
    constexpr R high = sizeof(R) == 4 ? R(0x1.62e4p-1) : R(0x1.62e42fefap-1);  // n * high is exact
    constexpr R low = R(0.693147180559945309417L - high);
    const V whole = __builtin_convertvector(n, V);
    return whole * high + (2 * s + (s * z * sum + whole * low));
}

// Overload for lanes, called by material.h.
template <class R>
inline Lanes<R> log_volume(Lanes<R> excess)
{
    return R(0.5) * log_of_one_plus(max(excess, Lanes<R>(crushed<R>)));
}

// Concatenates two registers.
template <class V>
[[gnu::always_inline]] inline auto joined(V low, V high)
{
    constexpr std::size_t count = 2 * sizeof(V) / sizeof(low[0]);
    return [&]<std::size_t... l>(std::index_sequence<l...>) __attribute__((always_inline))
    {
        return __builtin_shufflevector(low, high, int(l)...);
    }
    (std::make_index_sequence<count>());
}

// Interleaves per four lanes: u0 v0 u1 v1 (half 0) or u2 v2 u3 v3 (half 1).
template <int half, class V>
[[gnu::always_inline]] inline V mixed(V u, V v)
{
    constexpr std::size_t count = sizeof(V) / sizeof(u[0]);
    return [&]<std::size_t... l>(std::index_sequence<l...>) __attribute__((always_inline))
    {
        return __builtin_shufflevector(u, v,
                                       int(l / 4 * 4 + 2 * half + l % 4 / 2 + l % 2 * count)...);
    }
    (std::make_index_sequence<count>());
}
// Transposes each 4 x 4 block formed by four lanes of a, b, c and d.
template <class V>
[[gnu::always_inline]] inline void transpose(V& a, V& b, V& c, V& d)
{
    const V ac = mixed<0>(a, c), AC = mixed<1>(a, c), bd = mixed<0>(b, d), BD = mixed<1>(b, d);
    a = mixed<0>(ac, bd), b = mixed<1>(ac, bd), c = mixed<0>(AC, BD), d = mixed<1>(AC, BD);
}

}  // namespace KNEAD_CPU_LEVEL
}  // namespace knead
