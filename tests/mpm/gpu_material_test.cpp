// Where log and exp enter, the device against the CPU, both in float and without contraction. What
// has only + - * / sqrt is the same to the bit. A logarithm or an exponential may differ by 4 ulp.
// Behind it, in a chain of operations, a difference is counted in units of 2^-23 (an ulp of a
// number is at most so much of it) of a scale: not of the result, which may be all but cancelled,
// but of the terms it is made of, times what each is amplified by. Bounds of chains that are not
// explained: what functions reach on these inputs that were made to err by 4 ulp, up or down by
// chance, and half as much again.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "host/scene/presets.h"
#include "host/solver/editable_simulator.h"
#include "host/solver/gpu/material.h"
#include "tests/solver/clay.h"

namespace knead {
namespace {

constexpr float dt = 1e-4f;
constexpr double unit = 0x1p-23;

// Places of a float between a and b, on a line on which neighbours are 1 apart.
double places(float a, float b)
{
    const auto place = [](float x) {
        std::int32_t bits;
        std::memcpy(&bits, &x, sizeof bits);
        return bits < 0 ? -double(bits & 0x7fffffff) : double(bits);
    };
    if (std::isnan(a) || std::isnan(b)) return std::isnan(a) && std::isnan(b) ? 0 : 1e30;
    return std::fabs(place(a) - place(b));
}

// The largest difference seen of each quantity, and what it may be.
class Differences {
  public:
    void see(const std::string& what, double difference, double bound)
    {
        Most& m = all[what];
        m.bound = bound, ++m.count;
        if (!(difference <= m.seen)) m.seen = difference;  // a NaN is the largest
    }
    void check() const
    {
        for (const auto& [what, m] : all) {
            std::printf("%-44s %7.2f of %5.1f, %ld times\n", what.c_str(), m.seen, m.bound,
                        m.count);
            EXPECT_LE(m.seen, m.bound) << what;
        }
    }

  private:
    struct Most {
        double seen = 0, bound = 0;
        long count = 0;
    };
    std::map<std::string, Most> all;
};

class GpuMaterial : public ::testing::Test {
  protected:
    void SetUp() override
    {
        if (!gpu_present()) GTEST_SKIP() << "no CUDA device";
    }
};

// Both libraries claim 1 ulp of the true value for each.
TEST_F(GpuMaterial, LogarithmsAndExponentialsAreWithinFourUlpOfTheCpus)
{
    std::vector<float> x;
    for (std::uint32_t bits = 0; bits < 0xffffff00u; bits += 1021) {
        float number;
        std::memcpy(&number, &bits, sizeof number);
        x.push_back(number);
    }
    const std::vector<Functions<float>> got = gpu_functions(x);
    Differences differences;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Functions<float> own = functions_of(x[i]);
        differences.see("log", places(got[i].log, own.log), 4);
        differences.see("exp", places(got[i].exp, own.exp), 4);
        differences.see("log1p", places(got[i].log1p, own.log1p), 4);
        differences.see("expm1", places(got[i].expm1, own.expm1), 4);
    }
    differences.check();
}

double largest(Vec3<float> v)
{
    return std::fmax(std::fabs(v.x), std::fmax(std::fabs(v.y), std::fabs(v.z)));
}
double largest(const Sym3<float>& e)
{
    return std::fmax(largest(Vec3<float>{e.xx, e.yy, e.zz}),
                     largest(Vec3<float>{e.xy, e.xz, e.yz}));
}
double apart(Vec3<float> a, Vec3<float> b) { return largest(a - b); }
double apart(const Sym3<float>& a, const Sym3<float>& b) { return largest(a - b); }
double sum(Vec3<float> v) { return double(v.x) + double(v.y) + double(v.z); }

// One particle's answers on both sides.
struct Pair {
    Particle<float> q;
    Material<float> m;
    Answers<float> cpu, gpu;

    bool snow() const { return m.plasticity == Plasticity::clamp; }
    double mu() const { return double(m.mu) * double(cpu.snow_hardening); }
    double lambda() const { return double(m.lambda) * double(cpu.snow_hardening); }
    double exponent() const { return snow() ? std::fabs(m.snow * std::expm1(double(q.k))) : 0; }
    double E() const { return largest(cpu.eps); }
};

// What comes of a single logarithm, and the exponential of it.
void see_strains(const Pair& p, Differences& d)
{
    d.see("eigenvalues", places(p.gpu.b.value.x, p.cpu.b.value.x), 0);
    d.see("ln J, ulp", places(p.gpu.log_volume, p.cpu.log_volume), 4);
    d.see("Hencky strains, ulp", places(p.gpu.eps.x, p.cpu.eps.x), 4);
    d.see("Hencky strains, ulp", places(p.gpu.eps.y, p.cpu.eps.y), 4);
    d.see("Hencky strains, ulp", places(p.gpu.eps.z, p.cpu.eps.z), 4);
    // exp(-y): the exponent y is off by 4 for its own exponential and 1 for a product, and
    // amplified by y.
    const double off = std::fabs(double(p.gpu.snow_hardening) - double(p.cpu.snow_hardening));
    d.see("snow's hardening", off / (unit * double(p.cpu.snow_hardening) * (1 + p.exponent())), 5);
}

const char* name(Elasticity e)
{
    return e == Elasticity::neo_hookean ? "neo-Hookean"
           : e == Elasticity::hencky    ? "Hencky"
                                        : "corotated";
}

// Stresses at the same Hencky strains: 4 for each function, 1 for each sum and product behind one.
void see_principal(const Pair& p, Differences& d)
{
    const Vec3<double> eps{p.q.e.xx, p.q.e.yy, p.q.e.zz};
    const double s = eps.x + eps.y + eps.z, max = std::max({eps.x, eps.y, eps.z}),
                 E = std::max({max, -eps.x, -eps.y, -eps.z});
    double scale = 2 * p.mu() * E + p.lambda() * std::fabs(s), bound = 0;
    if (p.m.elasticity == Elasticity::neo_hookean) {
        scale = p.mu() * std::fabs(std::expm1(2 * E)) + p.lambda() * std::fabs(s);
        bound = 4 + 2;
    } else if (p.m.elasticity == Elasticity::fixed_corotated) {
        scale = 2 * p.mu() * std::expm1(E) * std::exp(E) +
                p.lambda() * std::fabs(std::expm1(s) * std::exp(s));
        bound = 4 + 4 + 3;
    }
    if (p.snow()) scale *= 1 + p.exponent(), bound += 5 + 1;
    const double off = apart(p.gpu.principal, p.cpu.principal);
    d.see(std::string("principal stress, ") + name(p.m.elasticity) + (p.snow() ? ", snow" : ""),
          off / (unit * scale + 1e-30), bound);
}

// Stress from the strain b - I. Volume's part and the deviator's often cancel, so that the scale is
// of their sizes.
void see_stress(const Pair& p, Differences& d)
{
    const double off = apart(p.gpu.stress, p.cpu.stress), L = std::fabs(p.cpu.log_volume);
    if (p.m.plasticity == Plasticity::fluid) {
        const double J = std::exp(double(p.cpu.log_volume));
        const double pressure = p.m.bulk * L * std::fmax(1, std::pow(J, -double(p.m.exponent)));
        const double shear = 2 * p.m.viscosity * largest(deviator(symmetric(p.q.C)));
        d.see("stress, liquid", off / (unit * J * (1 + L) * (pressure + shear)), 18);
        return;
    }
    double scale = p.mu() * largest(p.q.e) + p.lambda() * L, bound = 4 + 2;
    if (p.m.elasticity == Elasticity::hencky) {
        scale = (2 * p.mu() + 3 * p.lambda()) * p.E();
        bound = 7;
    } else if (p.m.elasticity == Elasticity::fixed_corotated) {
        const double s = std::fmax(0, sum(p.cpu.eps));
        scale = 4 * p.mu() * p.E() * std::exp(2 * p.E()) + 6 * p.lambda() * p.E() * std::exp(2 * s);
        bound = 7;
    }
    if (p.snow()) scale *= 1 + p.exponent(), bound += 5 + 1;
    d.see(std::string("stress, ") + name(p.m.elasticity) + (p.snow() ? ", snow" : ""),
          off / (unit * scale + 1e-30), bound);
}

// How much of Herschel-Bulkley's two logarithms and two exponentials reaches the strain: the share
// of the overstress that flows is off by no more than their sizes over the flow index.
double paste(const Pair& p)
{
    if (p.m.plasticity != Plasticity::herschel_bulkley) return 0;
    const double trial = size(deviator(cast<double>(p.cpu.stress)));
    const double over = trial - yield_root * double(p.m.yield), mu = double(p.m.mu),
                 n = p.m.exponent;
    if (over <= 0) return 0;
    const double shear_stress = over / std::sqrt(2.0);
    const double logs = std::fabs(std::log(p.m.viscosity / shear_stress)) +
                        n * std::fabs(std::log(shear_stress / (mu * double(dt))));
    return over / mu * (1 + logs) / std::fmin(n, 1);
}

// A return map without functions: neo-Hookean von Mises. The mean of its strain is the root of a
// cubic. The GPU's divisions are within 2 ulp (cuda/math/fast.h), and the last step that they scale
// is far below a unit, so that the mean may be rounded the other way, and each of the diagonal's
// values once more.
// Others, in Hencky strains, are projections onto what a material bears: they bring no two strains
// further apart than their logarithms put them, but for sand, whose shear also hangs on its
// pressure. Where a map is a root that is searched until 1e-6 of its range is left, 8.4 units, each
// side may stop anywhere in that.
void see_yielded(const Pair& p, Differences& d)
{
    const Particle<float>&a = p.gpu.yielded, &b = p.cpu.yielded;
    const double off = apart(a.e, b.e), off_k = std::fabs(double(a.k) - double(b.k));
    const double L = std::fabs(p.cpu.log_volume), E = p.E();
    const bool neo = p.m.elasticity == Elasticity::neo_hookean;
    if (p.m.plasticity == Plasticity::fluid) {
        const double back = std::fmax(1, std::exp(2.0 / 3 * double(p.cpu.log_volume)));
        d.see("return map, liquid", off / (unit * back * L + 1e-30), 4 + 4 + 2);
    } else if (p.m.plasticity == Plasticity::none ||
               (p.m.plasticity == Plasticity::von_mises && neo)) {
        d.see("return map without functions", (off + off_k) / (unit * (1 + E)), 2);
    } else if (p.snow()) {
        // Three steps of stress over a slope that is no smaller than it over the strains' sum; a
        // stress is off by 9 at most, see see_principal(), the slope by an exponential.
        const double bound = 8 + 3 * (9 + 4 + 1);
        d.see("return map, snow's strain", off / (unit * 2 * std::exp(2 * E) * 3 * E), bound);
        d.see("packing of snow", off_k / (unit * (9 * E + std::fabs(b.k))), bound);
    } else if (p.m.plasticity == Plasticity::herschel_bulkley && neo) {
        // The deviator is scaled, and its mean found for the same volume: over the cubic's slope.
        const double mean = 1 + trace(b.e) / 3, kept = size(deviator(b.e));
        const double slope = 3 * mean * mean - kept * kept / 2;
        const double scale = paste(p) * (1 + 3 * kept / slope) + largest(b.e);
        d.see("return map, neo-Hookean paste", off / (unit * scale), 0.7);
        d.see("plastic strain, neo-Hookean paste", off_k / (unit * (paste(p) + b.k)), 0.7);
    } else {
        double scale = E + paste(p);
        if (p.m.plasticity == Plasticity::drucker_prager)
            scale += E * p.m.friction * (3 * p.m.lambda + 2 * p.m.mu) / (2 * p.m.mu);
        const bool searched = p.m.elasticity != Elasticity::hencky;
        const char* what = searched ? "return map by a searched root" : "return map, Hencky";
        const double bound = 8 + (searched ? 2 * 8.4 : 0);
        d.see(what, off / (unit * 2 * std::exp(2 * E) * scale), bound);
        d.see(std::string(what) + ", memory", off_k / (unit * (scale + std::fabs(p.q.k))), bound);
    }
}

std::vector<Material<float>> all_materials()
{
    std::vector<Material<float>> all;
    for (const std::string& preset_name : preset_names())
        all.push_back(cast<float>(preset(preset_name)));
    for (const Elasticity elasticity : elasticities)
        for (const Plasticity plasticity : plasticities) {
            if (!go_together(elasticity, plasticity)) continue;
            Material<float> m = clay<float>(elasticity, plasticity);
            m.hardening = 1e5f, m.exponent = plasticity == Plasticity::fluid ? 7 : 0.6f,
            m.cohesion = 0.005f;
            all.push_back(m);
        }
    return all;
}

// Particles of every material, from hardly to violently strained, each on both sides.
std::vector<Pair> pairs()
{
    const std::vector<Material<float>> materials = all_materials();
    std::vector<Particle<float>> particles;
    Draw draw(5);
    for (std::size_t m = 0; m < materials.size(); ++m)
        for (int i = 0; i < 6000; ++i) {
            Particle<float> q{};
            q.e = cast<float>(draw.strain(i % 3 == 0 ? 1e-3 : i % 3 == 1 ? 0.1 : 0.3));
            q.C = cast<float>(draw.matrix(10));
            q.k = float(materials[m].plasticity == Plasticity::clamp ? draw.in(-0.3, 0.3)
                                                                     : draw.in(0, 0.05));
            q.object = int(m);
            particles.push_back(q);
        }
    const std::vector<Answers<float>> got = gpu_answers(particles, materials, dt);
    std::vector<Pair> out;
    for (std::size_t i = 0; i < got.size(); ++i) {
        const Material<float>& m = materials[std::size_t(particles[i].object)];
        out.push_back({particles[i], m, answers(particles[i], m, dt), got[i]});
    }
    return out;
}

TEST_F(GpuMaterial, StrainsAndStressesAreWithinFourUlpForEachLogarithmAndExponential)
{
#ifndef KNEAD_VERIFY
    GTEST_SKIP() << "contraction changes what goes into a logarithm: build with KNEAD_VERIFY";
#endif
    Differences differences;
    for (const Pair& p : pairs()) {
        see_strains(p, differences);
        if (p.m.plasticity != Plasticity::fluid) see_principal(p, differences);
        see_stress(p, differences);
        see_yielded(p, differences);
    }
    differences.check();
}

}  // namespace
}  // namespace knead
