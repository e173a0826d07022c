// Material functions evaluated on the device, value by value, for comparison with the CPU in tests:
// log and exp are rounded differently by every library.
#pragma once
#include <vector>

#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/plasticity.h"

namespace knead {

// The functions of the standard library that the stages call.
template <class R>
struct Functions {
    R log, exp, log1p, expm1;
};
template <class R>
HD Functions<R> functions_of(R x)
{
    return {std::log(x), std::exp(x), std::log1p(x), std::expm1(x)};
}

// All material functions of one particle, in order of the number of logarithms involved.
template <class R>
struct Answers {
    Eigen<R> b;           // of the strain; no log enters
    R log_volume;         // ln J
    Vec3<R> eps;          // principal Hencky strains
    R snow_hardening;     // snow's hardening
    Vec3<R> principal;    // principal stresses at Hencky strains e.xx, e.yy, e.zz [Pa]
    Sym3<R> stress;       // [Pa]
    Particle<R> yielded;  // after the return map
};
template <class R>
HD Answers<R> answers(const Particle<R>& q, const Material<R>& m, R dt)
{
    const Eigen<R> b = eigen(q.e);
    Particle<R> yielded = q;
    yield(yielded, m, dt);
    return {b,
            log_volume(determinant_excess(q.e)),
            hencky(b.value),
            snow_hardening(m, q.k),
            principal_stress(m, q.k, {q.e.xx, q.e.yy, q.e.zz}),
            kirchhoff_stress(q, m),
            yielded};
}

// Evaluated on the device; Particle::object is the index of its material. Errors as of
// gpu_solver().
std::vector<Functions<float>> gpu_functions(const std::vector<float>& x);
std::vector<Answers<float>> gpu_answers(const std::vector<Particle<float>>& particles,
                                        const std::vector<Material<float>>& materials, float dt);

}  // namespace knead
