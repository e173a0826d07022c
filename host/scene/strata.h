// Particles by stratified sampling: a lattice of strata, each of a particle's volume, one particle
// in each at a hashed place. That is its middle tenth, for uneven particles soften clay; its middle
// half where a cell holds fewer than eight, for the planes of so wide a lattice part when it is
// stretched. Where a surface cuts strata: packing.h.
#pragma once
#include <cstddef>
#include <cstdint>

#include "cuda/math/vec.h"

namespace knead {

namespace strata {

inline std::uint64_t mixed(std::uint64_t z)  // splitmix64's finaliser [Steele 2014]
{
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
}

// Three numbers in [0, 1) for one stratum.
inline Vec3<double> hashed(unsigned seed, std::size_t object, Int3 stratum)
{
    std::uint64_t z = mixed(0x9e3779b97f4a7c15u + seed);
    for (std::uint64_t part : {std::uint64_t(object), std::uint64_t(stratum.x),
                               std::uint64_t(stratum.y), std::uint64_t(stratum.z)})
        z = mixed(z + 0x9e3779b97f4a7c15u * (part + 1));
    const auto next = [&] {
        z += 0x9e3779b97f4a7c15u;
        return double(mixed(z) >> 11) * 0x1p-53;
    };
    const double x = next(), y = next();
    return {x, y, next()};
}

}  // namespace strata

// Where the particle of a stratum of edge h [m] goes; the stratum reaches from h s to h (s + 1).
// per_cell is how many particles a cell of the solver has.
inline Vec3<double> stratum_place(unsigned seed, std::size_t object, Int3 s, double h,
                                  double per_cell)
{
    const double width = per_cell < 8 ? 0.5 : 0.1, low = (1 - width) / 2;
    const Vec3<double> u = strata::hashed(seed, object, s);
    return {h * (s.x + low + width * u.x), h * (s.y + low + width * u.y),
            h * (s.z + low + width * u.z)};
}

}  // namespace knead
