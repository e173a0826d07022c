// Particles that are strained a little further in every step, for the return maps.
#pragma once
#include "cuda/mpm/g2p.h"
#include "cuda/mpm/plasticity.h"
#include "host/bench/ball.h"
#include "profiling/micro/bench.cuh"

namespace knead::micro {

constexpr int steps = 16;

// A clay whose maps are compiled for one elasticity. It yields from a shear of about 1 % on.
HD Material<float> weak_clay(Elasticity elasticity)
{
    Material<float> m{};
    m.elasticity = elasticity;
    m.plasticity = Plasticity::von_mises;
    m.density = 1000, m.mass = 1, m.volume = 1e-3f;
    m.mu = 3.8e5f, m.lambda = 5.8e5f, m.bulk = 1e6f, m.exponent = 1;
    m.yield = 1e4f, m.yield_floor = 1e2f;
    return m;
}

// The velocity gradient of particle i times the length of a step: some shear, little volume.
HD Mat3<float> stretch_of(unsigned i)
{
    const auto some = [i](unsigned k) { return 0.02f * (random(9 * i + k) - 0.5f); };
    const float shear = random(9 * i) < 0.5f ? 0.02f : -0.02f;
    return {{some(1), shear, some(2)},
            {some(3), -0.5f * some(1), some(4)},
            {shear, some(5), -0.5f * some(1)}};
}

}  // namespace knead::micro
