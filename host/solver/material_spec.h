// Materials in user units, the valid ranges of their quantities, and the conversion to solver
// constants. The single source of valid materials for scene files, panels and edits.
#pragma once
#include <optional>
#include <span>
#include <string>

#include "cuda/mpm/material_data.h"

namespace knead {

// A material in measurable quantities. Quantities that its plasticity does not use are 0 or
// ignored.
struct MaterialSpec {
    std::string name;
    Elasticity elasticity;
    Plasticity plasticity;
    double density;             // [kg/m^3]
    double young, poisson;      // Young's modulus [Pa], Poisson's ratio [1]; unused by fluids
    double yield = 0;           // uniaxial yield stress [Pa]
    double hardening = 0;       // slope of the yield stress over plastic strain [Pa]
    double yield_floor = 0;     // lower bound of softening [Pa]
    double friction_angle = 0;  // internal friction [degrees]
    double cohesion = 0;        // Mohr-Coulomb: shear strength at zero pressure [Pa]
    double compress = 0, stretch = 0, snow = 0;  // clamp: bounds and hardening exponent [1]
    double viscosity = 0;  // fluid: [Pa s]; Herschel-Bulkley: consistency [Pa s^exponent]
    double exponent = 1;   // Herschel-Bulkley: flow index; fluid: of the pressure law [1]
    double bulk = 0;       // fluid: slope of the pressure over volume strain [Pa]
};

// Computes Lame parameters, and the Drucker-Prager cone that meets Mohr-Coulomb in triaxial
// compression.
Material<double> made(const MaterialSpec& spec);
// Inverse of made(); `name` stays empty.
MaterialSpec stated(const Material<double>& material);

// Range of a slider. Values beyond it, within the quantity's own range, can be typed or given in a
// scene.
struct SliderRange {
    double low = 0, high = 0;  // both 0: no slider
    bool logarithmic = false;
};

struct MaterialQuantity {
    const char* key;   // in scene files
    const char* name;  // on panels
    const char* unit;
    double MaterialSpec::*value;
    double low, high;  // valid range, inclusive
    SliderRange slider;
    bool (*used)(const MaterialSpec&);
};
std::span<const MaterialQuantity> material_quantities();
// By key. Throws std::out_of_range for an unknown key.
const MaterialQuantity& material_quantity(const std::string& key);

// Why a material is invalid: a quantity in use is out of range or inconsistent with the others.
struct MaterialFault {
    std::string key, expected, found;
    std::string text() const;  // one short sentence
};
// The first fault; empty for a valid material.
std::optional<MaterialFault> fault_of(const MaterialSpec& spec);

constexpr double most_gravity = 1000;  // along each axis [m/s^2]

}  // namespace knead
