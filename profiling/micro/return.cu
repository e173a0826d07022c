// What a step's strain and return map cost, by how the singular values are come by: not at all, as
// eigenvalues of b = F F^T, or from F itself.
#include "profiling/micro/yielding.cuh"

namespace knead::micro {
namespace {

enum class Map {
    elastic,      // strain alone
    neo_hookean,  // the deviator of b is scaled: no eigenvalues
    eigen,        // Hencky strains from the eigenvalues of b
    svd           // Hencky strains from the singular values of F
};

// F = U diag(s) V^T.
struct Singular {
    Mat3<float> U, V;
    Vec3<float> s;
};

// Columns u and v of A and of V are turned until those of A are at a right angle.
__device__ void turn(Vec3<float>& u, Vec3<float>& v, Vec3<float>& p, Vec3<float>& q)
{
    const float cross_term = dot(u, v);
    if (cross_term == 0) return;
    const float theta = (dot(v, v) - dot(u, u)) / (2 * cross_term);
    const float root = sqrtf(theta * theta + 1);
    const float tan = theta < 0 ? 1 / (theta - root) : 1 / (theta + root);
    const float c = 1 / sqrtf(tan * tan + 1), s = tan * c;
    const Vec3<float> u0 = u, p0 = p;
    u = c * u0 - s * v;
    v = s * u0 + c * v;
    p = c * p0 - s * q;
    q = s * p0 + c * q;
}

// One-sided Jacobi: as many sweeps as the symmetric one of cuda/math/sym_eigen.h.
__device__ Singular singular(Mat3<float> F)
{
    Mat3<float> V = diagonal(1.0f);
    for (int sweep = 0; sweep < 4; ++sweep) {
        turn(F.a, F.b, V.a, V.b);
        turn(F.a, F.c, V.a, V.c);
        turn(F.b, F.c, V.b, V.c);
    }
    const Vec3<float> s{length(F.a), length(F.b), length(F.c)};
    return {{(1 / s.x) * F.a, (1 / s.y) * F.b, (1 / s.z) * F.c}, V, s};
}

// The return map of cuda/mpm/plasticity.h for Hencky's elasticity, on F.
__device__ bool yield_by_svd(Mat3<float>& F, const Material<float>& m, float& k, float dt)
{
    const Singular f = singular(F);
    const Vec3<float> eps{logf(f.s.x), logf(f.s.y), logf(f.s.z)};
    const float trial = deviatoric(principal_stress(m, k, eps));
    const Return<float> r = return_magnitude(m, trial, m.mu, k, dt);
    if (r.slip == 0) return false;
    const float mean = (eps.x + eps.y + eps.z) / 3, t = r.stress / trial;
    const auto kept = [&](float e) { return expf(mean + t * (e - mean)); };
    const Mat3<float> US{kept(eps.x) * f.U.a, kept(eps.y) * f.U.b, kept(eps.z) * f.U.c};
    F = US * transpose(f.V);
    k += 0.8164966f * r.slip;
    return true;
}

// b - I of a deformation gradient.
__device__ Sym3<float> strain_of(const Mat3<float>& F)
{
    const Mat3<float> b = F * transpose(F);
    return {b.a.x - 1, b.b.y - 1, b.c.z - 1, b.b.x, b.c.x, b.c.y};
}

template <Map map>
__global__ void __launch_bounds__(threads) map_kernel(float4* strains, float2* rest, int count)
{
    const int i = int(blockIdx.x * threads + threadIdx.x);
    if (i >= count) return;
    const Material<float> m =
        weak_clay(map == Map::neo_hookean ? Elasticity::neo_hookean : Elasticity::hencky);
    const Mat3<float> L = stretch_of(unsigned(i));
    Particle<float> q{};
    Mat3<float> F = diagonal(1.0f);
    unsigned yielded = 0;
#pragma unroll 1
    for (int step = 0; step < steps; ++step) {
        if constexpr (map == Map::svd) {
            F = F + L * F;
            yielded += yield_by_svd(F, m, q.k, 1);
        } else {
            q.e = advance_b(q.e, L, 1.0f);
            if constexpr (map != Map::elastic) yielded += yield(q, m, 1.0f);
        }
    }
    const Sym3<float> e = map == Map::svd ? strain_of(F) : q.e;
    strains[i] = {e.xx, e.yy, e.zz, e.xy};
    rest[i] = {q.k, float(yielded)};
}

struct Result {
    std::vector<float4> strains;
    std::vector<float2> rest;
};

template <Map map>
Result time_map(Bench& bench, const char* what, const std::function<bool(const Result&)>& right)
{
    constexpr int count = 1 << 20;
    DeviceArray<float4> strains(count);
    DeviceArray<float2> rest(count);
    must_not_spill(what, map_kernel<map>);
    Row row{"return", what, "particle and step"};
    row.count = double(count) * steps;
    Result result;
    bench.add(
        row, [] {},
        [&] {
            launch("return", map_kernel<map>, count / threads, threads, bench.stream,
                   strains.data(), rest.data(), count);
        },
        [&] {
            result = {strains.downloaded(), rest.downloaded()};
            return right(result);
        });
    return result;
}

// Particle by particle as on the CPU in double, but for rounding.
bool as_on_cpu(const Result& found, Elasticity elasticity, bool plastic)
{
    const Material<double> m = cast<double>(weak_clay(elasticity));
    for (unsigned i = 0; i < found.strains.size(); i += 997) {
        const Mat3<float> L = stretch_of(i);
        Particle<double> q{};
        for (int step = 0; step < steps; ++step) {
            q.e = advance_b(q.e, {cast<double>(L.a), cast<double>(L.b), cast<double>(L.c)}, 1.0);
            if (plastic) yield(q, m, 1.0);
        }
        const float4& e = found.strains[i];
        const double off = std::fabs(e.x - q.e.xx) + std::fabs(e.y - q.e.yy) +
                           std::fabs(e.z - q.e.zz) + std::fabs(e.w - q.e.xy) +
                           std::fabs(found.rest[i].x - q.k);
        if (!(off < 1e-4)) return false;
    }
    return true;
}

// Most steps must yield, or the map is not what is timed.
bool plasticity(const Result& found)
{
    double all = 0;
    for (const float2& r : found.rest) all += double(r.y);
    return all > 0.9 * steps * double(found.rest.size());
}

}  // namespace

void measure_return(Bench& bench)
{
    time_map<Map::elastic>(bench, "strain alone: elastic",
                           [](const Result& r) { return as_on_cpu(r, Elasticity::hencky, false); });
    time_map<Map::neo_hookean>(
        bench, "von Mises, neo-Hookean: no eigenvalues", [](const Result& r) {
            return plasticity(r) && as_on_cpu(r, Elasticity::neo_hookean, true);
        });
    time_map<Map::eigen>(bench, "von Mises, Hencky: eigenvalues of b", [](const Result& r) {
        return plasticity(r) && as_on_cpu(r, Elasticity::hencky, true);
    });
    time_map<Map::svd>(bench, "von Mises, Hencky: singular values of F", [&](const Result& r) {
        return plasticity(r) && as_on_cpu(r, Elasticity::hencky, true);
    });
}

}  // namespace knead::micro
