// Stratified sampling: a lattice of strata, each with the volume of one particle, with one particle
// per stratum at a hashed position in its central tenth, because uneven particles soften clay; in
// its central half where a cell has fewer than eight particles, because the planes of so coarse a
// lattice separate when stretched. Strata cut by a surface: packing.h.
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

// Three pseudorandom numbers in [0, 1) per stratum.
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

// Position of the particle of a stratum with edge h [m], which spans h s to h (s + 1). per_cell:
// particles per cell of the solver.
inline Vec3<double> stratum_place(unsigned seed, std::size_t object, Int3 s, double h,
                                  double per_cell)
{
    const double width = per_cell < 8 ? 0.5 : 0.1, low = (1 - width) / 2;
    const Vec3<double> u = strata::hashed(seed, object, s);
    return {h * (s.x + low + width * u.x), h * (s.y + low + width * u.y),
            h * (s.z + low + width * u.z)};
}

}  // namespace knead
