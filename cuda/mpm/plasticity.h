// Return maps from a trial strain. Each is consistent with the stress of material.h, where
// go_together() allows it: it scales the deviator of the strain until the stress itself lies on the
// yield surface, at constant volume.  (10), (11)
#pragma once
#include "cuda/math/fast.h"
#include "cuda/mpm/material.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"

namespace knead {

// Magnitude of the deviator of principal values.
template <class R>
HD R deviatoric(Vec3<R> t)
{
    const R mean = (t.x + t.y + t.z) / 3;
    const Vec3<R> d = t - Vec3<R>{mean, mean, mean};
    return std::sqrt(dot(d, d));
}

// von Mises: uniaxial yield stress [Pa] at plastic strain k. T may hold values of many particles.
template <class R, class T>
HD T yield_stress(const Material<R>& m, T k)
{
    return max(T(m.yield) + T(m.hardening) * k, T(m.yield_floor));
}

// Conservative test that neo-Hookean clay is within its yield surface: (11) squared, with a margin
// for rounding, so that vectorised code can skip the return map.
template <class R, class T>
HD auto surely_elastic(const Material<R>& m, const Sym3<T>& e, T k)
{
    const T shear = T(m.mu * m.mu) * norm_squared(deviator(e)), yield = yield_stress(m, k);
    return shear < T(R(0.6666)) * yield * yield;  // 2/3 less the margin
}

// Deviatoric stress [Pa] after von Mises or Herschel-Bulkley flow from a trial one, and the plastic
// strain increment. `stiffness` is the slope of |dev tau| / 2 over strain [Pa].
template <class R>
struct Return {
    R stress, slip;
};
template <class R>
HD Return<R> return_magnitude(const Material<R>& m, R trial, R stiffness, R k, R dt)
{
    const R root = R(0.816496580927726);  // sqrt(2/3): from uniaxial to deviatoric magnitude
    if (m.plasticity == Plasticity::von_mises) {
        const R yield = yield_stress(m, k);
        if (trial <= root * yield) return {trial, 0};
        const R slope = yield > m.yield_floor || m.hardening > 0 ? m.hardening : R(0);
        const R soft = max(2 * stiffness + R(2) / 3 * slope, R(0.2) * stiffness);
        const R slip = (trial - root * yield) / soft;
        const R stress = max(trial - 2 * stiffness * slip, root * m.yield_floor);
        return {stress, (trial - stress) / (2 * stiffness)};
    }
    const R yield = root * m.yield;
    if (trial <= yield) return {trial, 0};
    // In simple shear the deviator is sqrt(2) times the shear stress, and the plastic rate of shear
    // sqrt(2) times slip / dt, which gives
    //   s + sqrt(2) stiffness dt ((s - yield) / (sqrt(2) viscosity))^(1 / exponent) = trial.
    // With u the logarithm of the share of the overstress that flows, and p and q the shares that
    // stay and flow, that is ln(p + q) = 0: convex in u, of slope between exponent and 1, so that
    // Newton converges monotonically from the corner of its two straight branches.
    const R over = trial - yield, shear = R(0.707106781186548) * over;
    const R a = std::log(m.viscosity / shear) + m.exponent * std::log(shear / (stiffness * dt));
    R u = min(R(0), -a / m.exponent), p = 0, q = 1;
    for (int i = 0; i < 6; ++i) {
        p = std::exp(a + m.exponent * u);
        q = std::exp(u);
        u = u - std::log(p + q) * (p + q) / (m.exponent * p + q);
    }
    return {yield + over * (p / (p + q)), over * (q / (p + q)) / (2 * stiffness)};
}

// neo-Hookean: dev tau = mu dev b, so the deviator of e is scaled and its mean solved for the same
// determinant, without eigenvectors. The root is the largest of a cubic, and Halley's iteration
// converges to it from above, starting at the trial's mean. The number of steps is fixed: an early
// exit makes the kernel spill. The root lies above `low`, where the slope vanishes, except for one
// value of b, hence the slope's floor. A mean below `low` belongs to no b.  (10)
template <class R>
HD Sym3<R> scale_deviator(const Sym3<R>& e, R ratio)
{
    const R excess = max(determinant_excess(e), crushed<R>);
    const Sym3<R> s = ratio * deviator(e);
    const R II = minors(s), rest = II + determinant(s) - excess;
    const R low = std::sqrt(max((R(-1) / 3) * II, R(0)));
    constexpr int steps = sizeof(R) == 4 ? 6 : 10;  // enough for a 20-fold decrease of the mean
    R m = (R(1) / 3) * trace(e);
    if (1 + m < low) m = 2 * low - 1;
    for (int i = 0; i < steps; ++i) {
        const R f = m * (3 + II + m * (3 + m)) + rest, square = (1 + m) * (1 + m);
        const R slope = max(3 * square + II, R(1e-3) * square + R(1e-6));
        const R bent = 2 * slope - 6 * f * fast_divide(1 + m, slope);  // f'' = 6 (1 + m)
        m = max(m - 2 * fast_divide(f, max(bent, slope)), low - 1);
    }
    return raised(s, m);
}

// The largest factor t in [0, 1] on the deviator `d` of Hencky strain, about the mean `mean`, for
// which |dev tau| <= bound(dev tau, pressure).
template <class R, class Bound>
HD R solve_return_scale(const Material<R>& m, R k, R mean, Vec3<R> d, Bound&& bound)
{
    const auto over = [&](R t) {
        const Vec3<R> tau =
            principal_stress(m, k, {mean + t * d.x, mean + t * d.y, mean + t * d.z});
        const R middle = (tau.x + tau.y + tau.z) / 3;
        const Vec3<R> s = tau - Vec3<R>{middle, middle, middle};
        return std::sqrt(dot(s, s)) - bound(s, -middle);
    };
    R low = 0, high = 1, f_low = over(R(0)), f_high = over(R(1));
    if (f_high <= 0) return 1;
    if (f_low >= 0) return 0;
    const R enough = (sizeof(R) == 4 ? R(1e-6) : R(1e-13)) * (f_high - f_low);
    int side = 0;
    for (int i = 0; i < 30; ++i) {  // regula falsi, Illinois variant
        const R t = (low * f_high - high * f_low) / (f_high - f_low), f = over(t);
        if (f <= enough && f >= -enough) return t;
        if (f > 0) {
            high = t, f_high = f;
            if (side > 0) f_low = f_low / 2;
            side = 1;
        } else {
            low = t, f_low = f;
            if (side < 0) f_high = f_high / 2;
            side = -1;
        }
    }
    return low;
}

// The strain with principal Hencky strains eps.
template <class R>
HD Sym3<R> from_hencky(const Mat3<R>& axes, Vec3<R> eps)
{
    return composed(axes, {std::expm1(2 * eps.x), std::expm1(2 * eps.y), std::expm1(2 * eps.z)});
}

template <class R>
HD bool yield_by_stress(Particle<R>& q, const Material<R>& m, R dt)
{
    if (m.elasticity == Elasticity::neo_hookean) {
        const R trial = m.mu * std::sqrt(norm_squared(deviator(q.e)));
        // A valid b has |dev b| <= sqrt(2/3) tr b; rounding can make an eigenvalue negative, and
        // even its trace.
        const R stiffness = max(m.mu * (1 + (R(1) / 3) * trace(q.e)), R(0.408248290463863) * trial);
        const Return<R> r = return_magnitude(m, trial, stiffness, q.k, dt);
        if (r.slip == 0) return false;
        q.e = scale_deviator(q.e, r.stress / trial);
        q.k += R(0.816496580927726) * r.slip;
        return true;
    }
    const Eigen<R> b = eigen(q.e);
    const Vec3<R> eps = hencky(b.value);
    const R trial = deviatoric(principal_stress(m, q.k, eps));
    const Return<R> r = return_magnitude(m, trial, m.mu, q.k, dt);
    if (r.slip == 0) return false;
    const R mean = (eps.x + eps.y + eps.z) / 3;
    const Vec3<R> d = eps - Vec3<R>{mean, mean, mean};
    const R t = m.elasticity == Elasticity::hencky
                    ? r.stress / trial
                    : solve_return_scale(m, q.k, mean, d, [&](Vec3<R>, R) { return r.stress; });
    q.e = from_hencky(b.axes, Vec3<R>{mean, mean, mean} + t * d);
    q.k += R(0.816496580927726) * r.slip;
    return true;
}

// Bound of |dev tau| over pressure for sand whose deviator has the principal values s: `friction`
// in triaxial compression, least in extension, as in Mohr-Coulomb. Between them the section of the
// cone is that of Matsuoka-Nakai: friction over the largest root of a cubic with one parameter, to
// which Newton's iteration converges from above, starting at the root in extension.  (11)
template <class R>
HD R friction_towards(R friction, Vec3<R> s)
{
    constexpr int steps = sizeof(R) == 4 ? 6 : 8;    // enough up to 60 degrees; slightly low above
    const R beta = R(0.204124145231932) * friction;  // 1 / (2 sqrt(6))
    const R B = 2 * beta * (1 + 2 * beta), size = std::sqrt(dot(s, s));
    const Vec3<R> n = size > 0 ? (1 / size) * s : Vec3<R>{};
    const R cosine = max(R(-1), min(R(1), R(-7.348469228349535) * (n.x * n.y * n.z)));
    R y = 1 + 2 * beta;
    for (int i = 0; i < steps; ++i) {
        const R slope = max(3 * y * y - 1 - B, R(1e-3));
        y = y - fast_divide(y * (y * y - 1 - B) + B * cosine, slope);
    }
    return friction / y;
}

// Sand: no tension beyond the tip, shear up to friction times pressure. Volume gained at the tip is
// stored and returned first; else alternating tension and compression would inflate the sand. [Klar
// 2016; Tampubolon 2017]
template <class R>
HD bool yield_sand(Particle<R>& q, const Material<R>& m)
{
    const Eigen<R> b = eigen(q.e);
    Vec3<R> eps = hencky(b.value);
    const R sum = eps.x + eps.y + eps.z + q.k;
    if (sum >= m.cohesion) {
        const R tip = m.cohesion / 3;
        q.e = from_hencky(b.axes, {tip, tip, tip});
        q.k = sum - m.cohesion;
        return true;
    }
    const R mean = sum / 3, shift = q.k / 3, tip = (m.lambda + R(2) / 3 * m.mu) * m.cohesion;
    eps = eps + Vec3<R>{shift, shift, shift};
    const Vec3<R> d = eps - Vec3<R>{mean, mean, mean};
    const auto bound = [&](Vec3<R> s, R pressure) {
        return friction_towards(m.friction, s) * max(pressure + tip, R(0));
    };
    R t = 1;
    if (m.elasticity == Elasticity::hencky) {
        const R trial = 2 * m.mu * std::sqrt(dot(d, d));
        const R max_shear = bound(d, -(3 * m.lambda + 2 * m.mu) * mean);
        if (trial > max_shear) t = max_shear / trial;
    } else {
        t = solve_return_scale(m, R(0), mean, d, bound);
    }
    const bool corrected = q.k != 0;
    if (t == 1 && !corrected) return false;
    q.k = 0;
    q.e = from_hencky(b.axes, Vec3<R>{mean, mean, mean} + t * d);
    return t < 1;
}

// Snow: principal stretches of the elastic deformation return to their bounds [Stomakhin 2013],
// each only as far as its own stress drives it. Clamping regardless of stress creates energy: snow
// compressed along one axis widens along the others without stress there, and removing that stretch
// stiffens the first axis. No step is larger than stress over the largest slope, so that none gains
// energy, in any order of the axes.  (11)
template <class R>
HD bool yield_snow(Particle<R>& q, const Material<R>& m)
{
    const Eigen<R> b = eigen(q.e);
    const R least = (1 - m.compress) * (1 - m.compress) - 1;
    const R most = (1 + m.stretch) * (1 + m.stretch) - 1;
    const auto within = [&](R e) { return e >= least && e <= most; };
    if (within(b.value.x) && within(b.value.y) && within(b.value.z)) return false;
    const R low = log_volume(least), high = log_volume(most);
    const Vec3<R> before = hencky(b.value);
    Vec3<R> eps = before;
    bool driven = false;
    ROLLED
    for (int k = 0; k < 3; ++k) {
        const R widest = max(max(eps.x, eps.y), eps.z);
        const R volume = max(eps.x, low) + max(eps.y, low) + max(eps.z, low);
        const R slope = largest_slope(m, m.mu, m.lambda, std::exp(2 * max(widest, R(0))),
                                      std::exp(max(volume, R(0))));
        const Vec3<R> tau = principal_stress(m, R(0), eps);  // hardening is a factor on both
        const auto back = [&](R x, R t) {
            if (x < low && t < 0) return min(low, x - t / slope);
            if (x > high && t > 0) return max(high, x - t / slope);
            return x;
        };
        const Vec3<R> to{back(eps.x, tau.x), back(eps.y, tau.y), back(eps.z, tau.z)};
        driven = driven || to.x != eps.x || to.y != eps.y || to.z != eps.z;
        eps = to;
    }
    if (!driven) return false;
    const Vec3<R> flowed = before - eps;
    q.k = clamp(q.k + flowed.x + flowed.y + flowed.z, R(-1), R(1));
    q.e = from_hencky(b.axes, eps);
    return true;
}

// Applies the material's return map to the trial strain in q; true if it yielded.
template <class R>
HD bool yield(Particle<R>& q, const Material<R>& m, R dt)
{
    switch (m.plasticity) {
        case Plasticity::none:
            return false;
        case Plasticity::von_mises:
        case Plasticity::herschel_bulkley:
            return yield_by_stress(q, m, dt);
        case Plasticity::drucker_prager:
            return yield_sand(q, m);
        case Plasticity::clamp:
            return yield_snow(q, m);
        case Plasticity::fluid:
            break;
    }
    q.e = isotropic(std::expm1(R(2) / 3 * log_volume(determinant_excess(q.e))));
    return false;
}

}  // namespace knead
