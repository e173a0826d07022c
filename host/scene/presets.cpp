#include "host/scene/presets.h"

#include "host/base/json_reader.h"

namespace knead {

namespace {

// The table of materials. Where the real stiffness would only shorten the substep without changing
// the shape, the value is lower than in nature, and the comment gives the reason.
const std::vector<MaterialSpec> table = {
    // Potter's clay as it is worked. Undrained shear strength 20 kPa lies between 1.7 kPa at
    // the liquid and 170 kPa at the plastic limit [Wroth & Wood 1978]; times sqrt(3): 35 kPa.
    // Stiffness about 30 times the strength, as saturated clays have at large strain.
    {.name = "clay",
     .elasticity = Elasticity::neo_hookean,
     .plasticity = Plasticity::von_mises,
     .density = 1700,
     .young = 1e6,
     .poisson = 0.4,
     .yield = 3.5e4},
    // The same clay with more water: shear strength 5 kPa.
    {.name = "soft-clay",
     .elasticity = Elasticity::neo_hookean,
     .plasticity = Plasticity::von_mises,
     .density = 1600,
     .young = 3e5,
     .poisson = 0.4,
     .yield = 9e3},
    // Oil-based modelling clay at 20 C: flow stress 0.1-0.2 MPa, rising a little with strain
    // [Sofuoglu & Rasty 2000]. Its Young's modulus in the first percent is some ten times more.
    {.name = "plasticine",
     .elasticity = Elasticity::neo_hookean,
     .plasticity = Plasticity::von_mises,
     .density = 1850,
     .young = 3e6,
     .poisson = 0.4,
     .yield = 1.2e5,
     .hardening = 4e4},
    // Moist sand: 35 degrees of friction, 1.5 kPa of apparent cohesion by capillary water. A grain
    // skeleton has 10-20 MPa; friction and cohesion determine the shape, so 2 MPa.
    {.name = "wet-sand",
     .elasticity = Elasticity::hencky,
     .plasticity = Plasticity::drucker_prager,
     .density = 1800,
     .young = 2e6,
     .poisson = 0.3,
     .friction_angle = 35,
     .cohesion = 1500},
    // [Stomakhin 2013], table 2.
    {.name = "snow",
     .elasticity = Elasticity::fixed_corotated,
     .plasticity = Plasticity::clamp,
     .density = 400,
     .young = 1.4e5,
     .poisson = 0.2,
     .compress = 0.025,
     .stretch = 0.0075,
     .snow = 10},
    // Gelatine of about 5 % by weight: 10 kPa, nearly incompressible; Poisson's ratio stays at
    // 0.45 so that the lattice does not lock.
    {.name = "jelly",
     .elasticity = Elasticity::neo_hookean,
     .plasticity = Plasticity::none,
     .density = 1050,
     .young = 1e4,
     .poisson = 0.45},
    // Bread dough before it rises: shear modulus some 9 kPa and a small yield stress, orders of
    // magnitude. In steady shear of doughs of flour and water 2395 Pa s^0.34 at 9 to 5000 per
    // second [Sharma, Hanna & Chen 1993].
    {.name = "dough",
     .elasticity = Elasticity::neo_hookean,
     .plasticity = Plasticity::herschel_bulkley,
     .density = 1200,
     .young = 2.5e4,
     .poisson = 0.45,
     .yield = 600,
     .viscosity = 2000,
     .exponent = 0.4},
    // Honey-like: 10 Pa s. A speed of sound of 30 m/s, ten times the speed caused by hands and
    // gravity, keeps the volume within a percent; real syrup would need substeps fifty times
    // shorter.
    {.name = "viscous-liquid",
     .elasticity = Elasticity::neo_hookean,
     .plasticity = Plasticity::fluid,
     .density = 1400,
     .young = 0,
     .poisson = 0,
     .viscosity = 10,
     .exponent = 7,
     .bulk = 1400.0 * 30 * 30},
};

}  // namespace

const std::vector<MaterialSpec>& material_specs() { return table; }

const std::vector<std::string>& preset_names()
{
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const MaterialSpec& r : material_specs()) all.push_back(r.name);
        return all;
    }();
    return names;
}

const MaterialSpec& material_spec(const std::string& name)
{
    for (const MaterialSpec& r : material_specs())
        if (r.name == name) return r;
    std::string all;
    for (const std::string& n : preset_names()) all += (all.empty() ? "" : ", ") + n;
    throw InputError("expected a preset (" + all + "), found \"" + name.substr(0, 60) +
                     "\"; the nearest is \"" + nearest_name(name, preset_names()) + "\"");
}

Material<double> preset(const std::string& name) { return made(material_spec(name)); }

}  // namespace knead
