// Materials as a person states them, and what the stages need from that.
#pragma once
#include <string>
#include <vector>

#include "cuda/mpm/material_data.h"
#include "host/scene/scene.h"

namespace knead {

// A material in measurable quantities. What its flow does not use is 0 or has no effect.
struct MaterialSpec {
    std::string name;
    Elasticity elasticity;
    Plasticity plasticity;
    double density;             // [kg/m^3]
    double young, poisson;      // Young's modulus [Pa], Poisson's ratio [1]; of a fluid unused
    double yield = 0;           // uniaxial yield stress [Pa]
    double hardening = 0;       // slope of the yield stress over plastic strain [Pa]
    double yield_floor = 0;     // softening stops here [Pa]
    double friction_angle = 0;  // internal friction [degrees]
    double cohesion = 0;        // Mohr-Coulomb: shear strength without pressure [Pa]
    double compress = 0, stretch = 0, snow = 0;  // clamp: bounds and hardening exponent [1]
    double viscosity = 0;  // fluid: [Pa s]; Herschel-Bulkley: consistency [Pa s^exponent]
    double exponent = 1;   // Herschel-Bulkley: flow index [1]; fluid: of the pressure law [1]
    double bulk = 0;       // fluid: slope of the pressure over volume strain [Pa]
};

const std::vector<MaterialSpec>& material_specs();
const MaterialSpec& material_spec(const std::string& name);  // throws InputError naming the nearest

// Lame parameters, and the Drucker-Prager cone that meets Mohr-Coulomb in triaxial compression.
Material<double> made(const MaterialSpec& material_spec);

}  // namespace knead
