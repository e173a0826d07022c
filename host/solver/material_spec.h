// Materials as a person states them, the ranges of their quantities, and what the stages need from
// that. The one place that says which materials there can be: scene files, panels and edits of a
// solver ask it.
#pragma once
#include <optional>
#include <span>
#include <string>

#include "cuda/mpm/material_data.h"

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

// Lame parameters, and the Drucker-Prager cone that meets Mohr-Coulomb in triaxial compression.
Material<double> made(const MaterialSpec& spec);
// The same backwards; `name` stays empty.
MaterialSpec stated(const Material<double>& material);

// Where sliders of a quantity begin and end; a value beyond, up to the quantity's own range, may be
// typed or stand in a scene.
struct SliderRange {
    double low = 0, high = 0;  // both 0: no slider
    bool logarithmic = false;
};

struct MaterialQuantity {
    const char* key;   // in scene files
    const char* name;  // on panels
    const char* unit;
    double MaterialSpec::*value;
    double low, high;  // what can be, both included
    SliderRange slider;
    bool (*used)(const MaterialSpec&);
};
std::span<const MaterialQuantity> material_quantities();
// By its key; throws std::out_of_range for one that there is not.
const MaterialQuantity& material_quantity(const std::string& key);

// Why a material cannot be: a quantity that it uses is out of its range, or does not go with the
// others.
struct MaterialFault {
    std::string key, expected, found;
    std::string text() const;  // a short sentence
};
// The first fault; nothing for a material that can be.
std::optional<MaterialFault> fault_of(const MaterialSpec& spec);

constexpr double most_gravity = 1000;  // along each axis [m/s^2]

}  // namespace knead
