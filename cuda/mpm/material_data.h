// The constants of a material, as the stages read them. Kilograms, metres, seconds, pascals.
#pragma once
#include "cuda/math/hd.h"

namespace knead {

enum class Elasticity : int { neo_hookean, fixed_corotated, hencky };
enum class Plasticity : int { none, von_mises, drucker_prager, clamp, herschel_bulkley, fluid };

// Whether a plasticity has a return map for this elasticity. Below a stretch of 1/2 the fixed
// corotated stress falls under further compression (6): scaling a deviator down to a yield surface
// would create energy there. Snow's clamp bounds the stretches themselves.
constexpr bool go_together(Elasticity elasticity, Plasticity plasticity)
{
    return elasticity != Elasticity::fixed_corotated || plasticity == Plasticity::none ||
           plasticity == Plasticity::clamp || plasticity == Plasticity::fluid;
}

// Whether snow with hardening exponent `snow` and critical compression `compress` dissipates energy
// as it is packed. Under isotropic pressure it flows at ln J = -3 compress, under the pressure p =
// 3 K compress, with the energy psi = p^2 / 2K. Packing by -d ln J_p = d raises the energy by `snow
// J_p psi d` through the modulus, and the flow dissipates p d: that must be more, up to J_p = 1 + 3
// / snow, beyond which snow does not soften further (6).
constexpr bool packing_gives_up_energy(double compress, double snow)
{
    return 1.5 * compress * (snow + 3) < 1;
}

// One object's material, and constants of its particles.
template <class R>
struct Material {
    Elasticity elasticity;
    Plasticity plasticity;
    R density;      // at rest [kg/m^3]
    R mu, lambda;   // Lame parameters [Pa]
    R bulk;         // of a fluid: slope of its pressure [Pa]
    R yield;        // von Mises, Herschel-Bulkley: uniaxial yield stress [Pa]
    R hardening;    // von Mises: slope of the yield stress over plastic strain [Pa]; < 0 softens
    R yield_floor;  // von Mises: softening stops here [Pa]
    R friction;     // Drucker-Prager: |dev tau| over pressure in triaxial compression, at most [1]
    R cohesion;     // Drucker-Prager: Hencky volume strain that the cone's tip bears [1]
    R compress, stretch;  // clamp: singular values stay in [1 - compress, 1 + stretch]
    R snow;               // clamp: hardening exponent [1]
    R viscosity;          // fluid: [Pa s]; Herschel-Bulkley: consistency [Pa s^exponent]
    R exponent;           // Herschel-Bulkley: flow index [1]; fluid: of the pressure law [1]
    R mass, volume;       // of one particle at rest [kg] [m^3]
    int category;         // surfaces are made per category; no stage reads it

    bool operator==(const Material&) const = default;
};

template <class To, class From>
HD Material<To> cast(const Material<From>& m)
{
    return {m.elasticity,   m.plasticity,   To(m.density),   To(m.mu),          To(m.lambda),
            To(m.bulk),     To(m.yield),    To(m.hardening), To(m.yield_floor), To(m.friction),
            To(m.cohesion), To(m.compress), To(m.stretch),   To(m.snow),        To(m.viscosity),
            To(m.exponent), To(m.mass),     To(m.volume),    m.category};
}

}  // namespace knead
