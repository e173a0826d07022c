// Edits of a particle between two frames.
#pragma once
#include "cuda/contact/skinning.h"
#include "cuda/math/vec.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"

namespace knead {

// Maps x to rotate(q, x) + p.
template <class R>
using RigidMotion = Joint<R>;

// Moves a particle as part of a rigid body. Velocity, its gradient and strain are rotated: b
// becomes Q b Q^T.
template <class R>
HD void move(Particle<R>& particle, const RigidMotion<R>& motion)
{
    const auto turned = [&](Vec3<R> v) { return rotate(motion.q, v); };
    const Mat3<R> Q{turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1})};
    particle.x = motion.p + Q * particle.x;
    particle.v = Q * particle.v;
    particle.C = Q * particle.C * transpose(Q);
    particle.e = symmetric(Q * full(particle.e) * transpose(Q));
}

// Changes the material law. The elastic strain stays; k is reset unless both laws define it alike.
template <class R>
HD void change_law(Particle<R>& particle, Plasticity from, Plasticity to)
{
    const auto counts_slip = [](Plasticity p) {
        return p == Plasticity::von_mises || p == Plasticity::herschel_bulkley;
    };
    if (from != to && !(counts_slip(from) && counts_slip(to))) particle.k = 0;
}

}  // namespace knead
