// What an edit between two frames does to a particle.
#pragma once
#include "cuda/contact/skinning.h"
#include "cuda/math/vec.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"

namespace knead {

// Takes x to rotate(q, x) + p.
template <class R>
using RigidMotion = Joint<R>;

// Moves a particle as part of a rigid body. Its velocity and the gradient of that turn with it, and
// so does its strain: b becomes Q b Q^T.
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

// Of another material from now on. The elastic strain stays; what k counts, another law counts from
// the beginning, but where it means the same to both.
template <class R>
HD void change_law(Particle<R>& particle, Plasticity from, Plasticity to)
{
    const auto counts_slip = [](Plasticity p) {
        return p == Plasticity::von_mises || p == Plasticity::herschel_bulkley;
    };
    if (from != to && !(counts_slip(from) && counts_slip(to))) particle.k = 0;
}

}  // namespace knead
