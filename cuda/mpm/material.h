// Constitutive laws: Kirchhoff stress from the elastic strain.  (4)-(7)
#pragma once
#include "cuda/math/sym_eigen.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/time_step.h"

namespace knead {

// Lower bound of det(b) - 1: below it a particle is crushed and its value is rounding error.
template <class R>
constexpr R crushed = R(-0.999999);

// ln J from det(b) - 1; the floor keeps a crushed particle's logarithm finite.
template <class R>
HD R log_volume(R excess)
{
    return R(0.5) * std::log1p(max(excess, crushed<R>));
}

// Snow hardens as it is packed: factor on mu and lambda, k = ln of the plastic volume ratio.
template <class R>
HD R snow_hardening(const Material<R>& q, R k)
{
    if (q.plasticity != Plasticity::clamp) return 1;
    return clamp(std::exp(-q.snow * std::expm1(k)), R(0.05), R(20));
}

// The volumetric part of a solid's Kirchhoff stress, per direction [Pa]; hardening: a factor on
// lambda.
template <class R>
HD R volume_stress(const Material<R>& q, R hardening, R log_J)
{
    const R lambda = hardening * q.lambda;
    if (q.elasticity == Elasticity::fixed_corotated)
        return lambda * std::expm1(log_J) * std::exp(log_J);
    return lambda * log_J;
}

// Principal Kirchhoff stresses [Pa] at principal Hencky strains eps [1] of a solid.
template <class R>
HD Vec3<R> principal_stress(const Material<R>& q, R k, Vec3<R> eps)
{
    const R h = snow_hardening(q, k), mu = h * q.mu;
    const R p = volume_stress(q, h, eps.x + eps.y + eps.z);
    if (q.elasticity == Elasticity::hencky)
        return {2 * mu * eps.x + p, 2 * mu * eps.y + p, 2 * mu * eps.z + p};
    if (q.elasticity == Elasticity::neo_hookean)
        return {mu * std::expm1(2 * eps.x) + p, mu * std::expm1(2 * eps.y) + p,
                mu * std::expm1(2 * eps.z) + p};
    const auto each = [&](R s) { return 2 * mu * std::expm1(s) * std::exp(s) + p; };
    return {each(eps.x), each(eps.y), each(eps.z)};
}

// Principal Hencky strains of b = I + e, from the eigenvalues of e.
template <class R>
HD Vec3<R> hencky(Vec3<R> e)
{
    return {log_volume(e.x), log_volume(e.y), log_volume(e.z)};
}

// Kirchhoff stress tau [Pa] of a neo-Hookean solid with these Lame parameters [Pa].
template <class R>
HD Sym3<R> neo_hookean_stress(const Sym3<R>& e, R mu, R lambda)
{
    return raised(mu * e, lambda * log_volume(determinant_excess(e)));
}

// A liquid's ln J, split into the part up to J^(1 - gamma) = 32 and the part beyond, where the
// stress is linear in ln J: substeps are shortened for this stiffening and no more.  (7), (22)
template <class R>
struct LiquidStrain {
    R log_J, beyond;  // both at most 0 under compression
};
template <class R>
HD LiquidStrain<R> liquid_strain(const Material<R>& m, R log_J)
{
    static_assert(most_stiffening == 32);
    constexpr R ln_32 = R(3.4657359027997265);
    if (!((1 - m.exponent) * log_J > ln_32)) return {log_J, 0};
    const R last = ln_32 / (1 - m.exponent);
    return {last, log_J - last};
}
// A liquid's Kirchhoff stress at rest, per direction, and its slope over ln J [Pa].  (7)
template <class R>
HD R liquid_stress(const Material<R>& m, R log_J)
{
    const R p = m.bulk / m.exponent * std::expm1(-m.exponent * log_J);
    return -p * std::exp(log_J);
}
template <class R>
HD R liquid_slope(const Material<R>& m, R log_J)
{
    const R g = m.exponent;
    return m.bulk * ((1 - 1 / g) * std::exp((1 - g) * log_J) + std::exp(log_J) / g);
}

// Kirchhoff stress tau [Pa] of a particle.
template <class R>
HD Sym3<R> kirchhoff_stress(const Particle<R>& q, const Material<R>& m)
{
    if (m.plasticity == Plasticity::fluid) {
        const LiquidStrain<R> s = liquid_strain(m, log_volume(determinant_excess(q.e)));
        R tau = liquid_stress(m, s.log_J);
        if (s.beyond < 0) tau += liquid_slope(m, s.log_J) * s.beyond;
        return (2 * m.viscosity * std::exp(s.log_J)) * deviator(symmetric(q.C)) + isotropic(tau);
    }
    if (m.elasticity == Elasticity::neo_hookean) {
        const R h = snow_hardening(m, q.k);
        return neo_hookean_stress(q.e, h * m.mu, h * m.lambda);
    }
    const Eigen<R> b = eigen(q.e);
    return composed(b.axes, principal_stress(m, q.k, hencky(b.value)));
}

// Upper bound of the eigenvalues of a symmetric matrix, by Gershgorin's circles.
template <class R>
HD R largest_at_most(const Sym3<R>& a)
{
    const R xy = std::abs(a.xy), xz = std::abs(a.xz), yz = std::abs(a.yz);
    return max(max(a.xx + xy + xz, a.yy + xy + yz), a.zz + xz + yz);
}

// The largest slope of a solid's stress over Hencky strain [Pa], at Lame parameters [Pa], for
// principal values of b up to `b` >= 1 and volume ratios up to J >= 1.
template <class R>
HD R largest_slope(const Material<R>& m, R mu, R lambda, R b, R J)
{
    if (m.elasticity == Elasticity::hencky) return 3 * lambda + 2 * mu;
    if (m.elasticity == Elasticity::neo_hookean) return 3 * lambda + 2 * mu * b;
    const R s = std::sqrt(b);
    return 2 * mu * (2 * b - s) + 3 * lambda * (2 * J * J - J);
}

// Bound on a substep: the largest slope of the stress over strain in this state, divided by the
// density [m^2/s^2]; per_density: 1 / density.  (22)
template <class R>
HD R stiffness(const Particle<R>& q, const Material<R>& m, R per_density)
{
    if (m.plasticity == Plasticity::fluid) {
        const R log_J = liquid_strain(m, log_volume(determinant_excess(q.e))).log_J;
        return 3 * per_density * liquid_slope(m, log_J);
    }
    const R h = snow_hardening(m, q.k) * per_density, mu = h * m.mu, lambda = h * m.lambda;
    const R b = 1 + max(R(0), largest_at_most(q.e));
    const bool corotated = m.elasticity == Elasticity::fixed_corotated;
    const R J = corotated ? std::sqrt(max(R(1), 1 + determinant_excess(q.e))) : R(1);
    return largest_slope(m, mu, lambda, b, J);
}
template <class R>
HD R stiffness(const Particle<R>& q, const Material<R>& m)
{
    return stiffness(q, m, 1 / m.density);
}

// Fastest elastic wave in the material at rest [m/s].
template <class R>
HD R sound_speed(const Material<R>& m)
{
    if (m.plasticity == Plasticity::fluid) return std::sqrt(m.bulk / m.density);
    return std::sqrt((m.lambda + 2 * m.mu) / m.density);
}

}  // namespace knead
