// One material point. Metres, seconds.
#pragma once
#include <cstddef>
#include <cstdint>

#include "cuda/math/vec.h"

namespace knead {

// One material point. `e` is the elastic left Cauchy-Green strain b - I: without the identity small
// strains of a stiff material keep their digits in float.
template <class R>
struct Particle {
    Vec3<R> x, v;  // position [m], velocity [m/s]
    Mat3<R> C;     // affine velocity: the gradient of the velocity [1/s]
    Sym3<R> e;     // b - I [1]
    R k;           // von Mises and Herschel-Bulkley: accumulated plastic strain; Drucker-Prager:
                   // volume correction; clamp: ln of the plastic volume ratio [1]
    int object;    // index of its Material
    std::uint32_t sides;  // which side of a cut, see cut.h; the top bit: held where it is, see
                          // cuda/mpm/sleep.h
    // Kernels without sleep do not test this: it costs registers.
    HD bool still() const { return (sides & still_bit) != 0; }
    HD std::uint32_t label() const { return sides & ~still_bit; }
    HD void hold(bool held) { sides = label() | (held ? still_bit : 0); }
    static constexpr std::uint32_t still_bit = 1u << 31;
};

template <class To, class From>
HD Particle<To> cast(const Particle<From>& q)
{
    return {cast<To>(q.x),
            cast<To>(q.v),
            {cast<To>(q.C.a), cast<To>(q.C.b), cast<To>(q.C.c)},
            {To(q.e.xx), To(q.e.yy), To(q.e.zz), To(q.e.xy), To(q.e.xz), To(q.e.yz)},
            To(q.k),
            q.object,
            q.sides};
}

// Up to this count particles have six extra rows (particles.cuh): the memory is negligible, and a
// kernel per row would take longer than moving its bytes.
constexpr std::size_t few_particles = std::size_t(5) << 19;

}  // namespace knead
