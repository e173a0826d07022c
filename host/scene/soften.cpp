#include "host/scene/soften.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "cuda/mpm/material.h"
#include "host/base/errors.h"
#include "host/scene/seed.h"

namespace knead {
namespace {

bool is_fluid(const Material<double>& m) { return m.plasticity == Plasticity::fluid; }

// True if the yield limit is a stress, to be compared with the stiffness.
bool yields_at_a_stress(const Material<double>& m)
{
    return m.plasticity == Plasticity::von_mises || m.plasticity == Plasticity::herschel_bulkley;
}

// Substeps per frame at rest, not rounded.  (22)
double substeps_needed(const Scene& scene, const Material<double>& m)
{
    const StepOptions& step = scene.setup.step;
    return frame_duration(scene) * std::sqrt(stiffness(Particle<double>{}, m)) /
           (step.courant * scene.setup.lattice.dx);
}

int whole(double substeps) { return int(std::ceil(substeps * (1 - 1e-9))); }

// Elastic strain at yield, or at loss of cohesion [1]; 0: the material gives strains, or does not
// yield.
double yield_strain(const Material<double>& m)
{
    if (yields_at_a_stress(m)) return m.yield / elastic_modulus(m);
    return m.plasticity == Plasticity::drucker_prager ? m.cohesion : 0;
}

// A pressure with a unit prefix: "4.7 MPa".
std::string pascals(double value)
{
    constexpr std::array<const char*, 4> prefixes{"", "k", "M", "G"};
    std::size_t at = 0;
    for (; at + 1 < prefixes.size() && value >= 999.5; ++at) value /= 1000;
    return fmt::format("{:.3g} {}Pa", value, prefixes[at]);
}

// The stated material, before softening.
void take_stated(Object& o)
{
    const double volume = o.material.volume;
    o.material = made(o.stated);
    o.material.volume = volume, o.material.mass = o.material.density * volume;
    o.material.category = o.category;
    o.softer = 1;
}

std::string share(double strain) { return fmt::format("{:.2g} %", 100 * strain); }

}  // namespace

double elastic_modulus(const Material<double>& m)
{
    if (is_fluid(m)) return m.bulk;
    return m.mu * (3 * m.lambda + 2 * m.mu) / (m.lambda + m.mu);
}

double softening(const Scene& scene, const Material<double>& given)
{
    if (scene.soften_beyond == 0) return 1;
    const double more = substeps_needed(scene, given) / scene.soften_beyond;
    return std::max(1.0, more * more);
}

Material<double> softer(Material<double> m, double times)
{
    m.mu /= times, m.lambda /= times, m.bulk /= times;
    m.cohesion *= times;  // a strain: the stress is kept
    return m;
}

void soften(Scene& scene)
{
    for (Object& o : scene.objects) take_stated(o);
    if (scene.soften_beyond == 0) return;
    if (scene.setup.step.fixed > 0)
        throw InputError(scene.path +
                         ": /step/soften_beyond: expected no step.fixed and not the clock "
                         "\"paper\", which fix the length of substeps");
    for (Object& o : scene.objects) {
        o.softer = softening(scene, o.material);
        if (o.softer == 1) continue;
        const double needed = substeps_needed(scene, o.material);
        o.material = softer(o.material, o.softer);
        const double strain = yield_strain(o.material);
        if (!(strain >= 1)) continue;
        throw InputError(fmt::format(
            "{}: /step/soften_beyond: expected at least {}, found {}: \"{}\" would be softened to "
            "{} and still yield only at {}, so that it would hardly flow at all",
            scene.path, int(needed * std::sqrt(strain / o.softer)) + 1, scene.soften_beyond, o.name,
            pascals(elastic_modulus(o.material)), pascals(strain * elastic_modulus(o.material))));
    }
}

std::string softened_text(const Scene& scene, const Object& o)
{
    if (o.softer == 1) return "";
    const Material<double>& m = o.material;
    const double modulus = elastic_modulus(m);
    const std::string constants = fmt::format("{}: simulated {} {} instead of {}", o.name,
                                              is_fluid(m) ? "with a bulk modulus of" : "at",
                                              pascals(modulus), pascals(modulus * o.softer));
    std::string text =
        fmt::format("{}, {} about {:.3g} times as far; {} substeps a frame instead of {}",
                    constants, is_fluid(m) ? "is compressed" : "bends", o.softer,
                    scene.soften_beyond, whole(std::sqrt(o.softer) * scene.soften_beyond));
    if (const double strain = yield_strain(m); strain > 0)
        text += fmt::format("; it yields at the same stress, a strain of {} instead of {}",
                            share(strain), share(strain / o.softer));
    if (m.plasticity == Plasticity::clamp)
        text += "; its critical strains are unchanged, the stresses smaller by the same factor";
    const double sag = m.density * length(scene.setup.gravity) * extents(o).y / modulus;
    if (sag > 0.01)
        text += fmt::format("; strain at its base under its own weight: {}", share(sag));
    return text;
}

}  // namespace knead
