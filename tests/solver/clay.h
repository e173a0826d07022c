// Material and measures for the tests of the return maps.
#pragma once
#include <cmath>

#include "cuda/mpm/plasticity.h"
#include "tests/solver/samples.h"

namespace knead {

constexpr Elasticity elasticities[] = {Elasticity::neo_hookean, Elasticity::fixed_corotated,
                                       Elasticity::hencky};
constexpr Elasticity yielding[] = {Elasticity::neo_hookean, Elasticity::hencky};
constexpr Plasticity plasticities[] = {
    Plasticity::none,  Plasticity::von_mises,        Plasticity::drucker_prager,
    Plasticity::clamp, Plasticity::herschel_bulkley, Plasticity::fluid};
constexpr double yield_root = 0.81649658092772603;  // sqrt(2/3): of the deviator over the stress

// E = 1 MPa, nu = 0.3; yields at 50 kPa
template <class R>
Material<R> clay(Elasticity elasticity, Plasticity plasticity)
{
    Material<R> m{};
    m.elasticity = elasticity;
    m.plasticity = plasticity;
    m.density = 1000;
    m.mu = R(1e6 / 2.6);
    m.lambda = R(0.3e6 / (1.3 * 0.4));
    m.bulk = 1e6;
    m.yield = 5e4;
    m.friction = R(0.6);
    m.compress = R(0.025);
    m.stretch = R(0.0075);
    m.snow = 10;
    m.viscosity = 100;
    m.exponent = 1;
    m.mass = m.volume = 1;
    return m;
}

template <class R>
Particle<R> strained_by(const Sym3<double>& e)
{
    Particle<R> q{};
    q.e = cast<R>(e);
    return q;
}

inline Sym3<double> from_stretch(const Mat3<double>& axes, Vec3<double> eps)
{
    return composed(axes, {std::expm1(2 * eps.x), std::expm1(2 * eps.y), std::expm1(2 * eps.z)});
}

template <class R>
Sym3<double> stress(const Particle<R>& q, const Material<R>& m)
{
    return cast<double>(kirchhoff_stress(q, m));
}
template <class R>
double shear(const Particle<R>& q, const Material<R>& m)
{
    return size(deviator(stress(q, m)));
}
template <class R>
double pressure(const Particle<R>& q, const Material<R>& m)
{
    return -trace(stress(q, m)) / 3;
}
template <class R>
double ln_J(const Particle<R>& q)
{
    return 0.5 * std::log1p(determinant_excess(cast<double>(q.e)));
}

}  // namespace knead
