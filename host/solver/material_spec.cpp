#include "host/solver/material_spec.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <stdexcept>

namespace knead {
namespace {

bool always(const MaterialSpec&) { return true; }
bool solid(const MaterialSpec& s) { return s.plasticity != Plasticity::fluid; }
bool fluid(const MaterialSpec& s) { return s.plasticity == Plasticity::fluid; }
bool hardens(const MaterialSpec& s) { return s.plasticity == Plasticity::von_mises; }
bool flows(const MaterialSpec& s)
{
    return s.plasticity == Plasticity::fluid || s.plasticity == Plasticity::herschel_bulkley;
}
bool yields(const MaterialSpec& s)
{
    return s.plasticity == Plasticity::von_mises || s.plasticity == Plasticity::herschel_bulkley;
}
bool grains(const MaterialSpec& s) { return s.plasticity == Plasticity::drucker_prager; }
bool clamps(const MaterialSpec& s) { return s.plasticity == Plasticity::clamp; }

using Spec = MaterialSpec;
constexpr SliderRange no_slider{};

const MaterialQuantity quantities[] = {
    {"density", "Density", "kg/m^3", &Spec::density, 1, 1e5, {100, 5000}, always},
    {"young", "Stiffness", "Pa", &Spec::young, 1, 1e12, {1e3, 1e7, true}, solid},
    {"poisson", "Poisson", "", &Spec::poisson, 0, 0.499, {0, 0.45}, solid},
    {"yield", "Yield", "Pa", &Spec::yield, 0, 1e12, {10, 1e6, true}, yields},
    {"hardening", "Hardening", "Pa", &Spec::hardening, -1e12, 1e12, {0, 1e6}, hardens},
    {"yield_floor", "Yield floor", "Pa", &Spec::yield_floor, 0, 1e12, no_slider, hardens},
    {"viscosity", "Viscosity", "Pa s", &Spec::viscosity, 0, 1e9, {0.1, 1e4, true}, flows},
    {"friction_angle", "Friction", "degrees", &Spec::friction_angle, 0, 89, {1, 60}, grains},
    {"cohesion", "Cohesion", "Pa", &Spec::cohesion, 0, 1e9, {0, 1e4}, grains},
    {"compress", "Compress", "", &Spec::compress, 0, 0.99, no_slider, clamps},
    {"stretch", "Stretch", "", &Spec::stretch, 0, 10, no_slider, clamps},
    {"snow", "Snow", "", &Spec::snow, 0, 100, no_slider, clamps},
    {"exponent", "Exponent", "", &Spec::exponent, 0.05, 20, no_slider, flows},
    {"bulk", "Bulk modulus", "Pa", &Spec::bulk, 1, 1e12, no_slider, fluid}};

constexpr double degree = std::numbers::pi / 180;

// Quantities that a plasticity law requires to be positive.
struct Need {
    const char* key;
    bool (*of)(const MaterialSpec&);
    const char* what;
};
const Need needs[] = {
    {"bulk", fluid, "a fluid's bulk modulus above 0 Pa"},
    {"young", solid, "a solid's Young's modulus above 0 Pa"},
    {"yield", hardens, "a yield stress above 0 Pa for \"von_mises\""},
    {"viscosity",
     [](const MaterialSpec& s) { return s.plasticity == Plasticity::herschel_bulkley; },
     "a consistency above 0 for \"herschel_bulkley\""},
    {"friction_angle", grains, "an angle above 0 degrees for \"drucker_prager\""}};

std::string range_text(const MaterialQuantity& q)
{
    const std::string unit = *q.unit ? std::string(" ") + q.unit : "";
    return fmt::format("{:g} to {:g}{}", q.low, q.high, unit);
}

}  // namespace

std::span<const MaterialQuantity> material_quantities() { return quantities; }

const MaterialQuantity& material_quantity(const std::string& key)
{
    const auto at = std::find_if(std::begin(quantities), std::end(quantities),
                                 [&](const MaterialQuantity& q) { return q.key == key; });
    if (at == std::end(quantities)) throw std::out_of_range("a material has no " + key);
    return *at;
}

std::string MaterialFault::text() const
{
    return fmt::format("{}: expected {}, found {}", key, expected, found);
}

std::optional<MaterialFault> fault_of(const MaterialSpec& spec)
{
    for (const Need& need : needs) {
        const double value = spec.*material_quantity(need.key).value;
        if (need.of(spec) && !(value > 0))
            return MaterialFault{need.key, need.what, fmt::format("{:.9g}", value)};
    }
    if (!go_together(spec.elasticity, spec.plasticity))
        return MaterialFault{"elasticity",
                             "\"neo_hookean\" or \"hencky\" for a plasticity with a yield surface "
                             "(\"fixed_corotated\" softens where it is pressed below half its "
                             "length)",
                             "\"fixed_corotated\""};
    if (clamps(spec) && !packing_gives_up_energy(spec.compress, spec.snow))
        return MaterialFault{
            "compress", "1.5 compress (snow + 3) below 1, or packing it would make energy",
            fmt::format("{:.9g} with a `snow` of {:.4g}", spec.compress, spec.snow)};
    for (const MaterialQuantity& q : quantities) {
        if (!q.used(spec)) continue;
        // Values converted back from Lame parameters carry rounding errors.
        constexpr double rounding = 1e-9;
        const double value = spec.*q.value;
        const bool low = value >= q.low - rounding * std::max(1.0, std::abs(q.low));
        if (!low || !(value <= q.high + rounding * std::abs(q.high)))
            return MaterialFault{q.key, range_text(q), fmt::format("{:.9g}", value)};
    }
    return {};
}

Material<double> made(const MaterialSpec& r)
{
    Material<double> m{};
    m.elasticity = r.elasticity;
    m.plasticity = r.plasticity;
    m.density = r.density;
    m.exponent = r.exponent;
    m.viscosity = r.viscosity;
    if (r.plasticity == Plasticity::fluid) {
        m.bulk = r.bulk;
        return m;
    }
    m.mu = r.young / (2 * (1 + r.poisson));
    m.lambda = r.young * r.poisson / ((1 + r.poisson) * (1 - 2 * r.poisson));
    m.bulk = m.lambda + 2 * m.mu / 3;
    m.yield = r.yield;
    m.hardening = r.hardening;
    m.yield_floor = r.yield_floor;
    m.compress = r.compress;
    m.stretch = r.stretch;
    m.snow = r.snow;
    const double angle = r.friction_angle * degree, s = std::sin(angle);
    // q = 6 s / (3 - s) p in triaxial compression, and |dev tau| = sqrt(2/3) q.
    m.friction = 2 * std::sqrt(6.0) * s / (3 - s);
    // The cone's tip is at tension c / tan(angle); divided by the bulk modulus it is a volume
    // strain.
    if (angle > 0) m.cohesion = r.cohesion / std::tan(angle) / m.bulk;
    return m;
}

MaterialSpec stated(const Material<double>& m)
{
    MaterialSpec spec{};
    spec.elasticity = m.elasticity, spec.plasticity = m.plasticity;
    spec.density = m.density;
    spec.exponent = m.exponent, spec.viscosity = m.viscosity;
    if (m.plasticity == Plasticity::fluid) {
        spec.bulk = m.bulk;
        return spec;
    }
    if (m.lambda + m.mu != 0) {
        spec.young = m.mu * (3 * m.lambda + 2 * m.mu) / (m.lambda + m.mu);
        spec.poisson = m.lambda / (2 * (m.lambda + m.mu));
    }
    spec.yield = m.yield, spec.hardening = m.hardening, spec.yield_floor = m.yield_floor;
    spec.compress = m.compress, spec.stretch = m.stretch, spec.snow = m.snow;
    const double s = 3 * m.friction / (2 * std::sqrt(6.0) + m.friction);
    // Coefficients beyond that of 90 degrees give NaN, which is out of every range.
    const double angle = std::asin(s);
    spec.friction_angle = angle / degree;
    if (s > 0) spec.cohesion = m.cohesion * std::tan(angle) * m.bulk;
    return spec;
}

}  // namespace knead
