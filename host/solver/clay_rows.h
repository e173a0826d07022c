// Clay and Gaussians at rest, as floats: what undo keeps of a simulator's state.
#pragma once
#include <cstdint>
#include <vector>

#include "cuda/splats/deform.h"

namespace knead {

constexpr std::size_t clay_planes = 10;  // x y z, e.xx yy zz xy xz yz, k: as in Particle

// Particles by id. Without velocities: these are 0.
struct ClayRows {
    std::size_t count = 0;
    std::vector<float> planes;         // clay_planes * count: number p of particle i at p*count + i
    std::vector<std::int32_t> object;  // count
    std::vector<std::uint32_t> sides;  // count: labels of cuts; never held (Particle::still_bit)
    std::vector<Gaussian<float>> gaussians;  // in the order of attachment
};

// Rows of `count` particles, all zero.
inline ClayRows empty_rows(std::size_t count)
{
    return {count,
            std::vector<float>(clay_planes * count),
            std::vector<std::int32_t>(count),
            std::vector<std::uint32_t>(count),
            {}};
}

// Particle i, at rest.
inline Particle<float> particle_at(const ClayRows& rows, std::size_t i)
{
    const auto plane = [&](std::size_t p) { return rows.planes[p * rows.count + i]; };
    Particle<float> q{};
    q.x = {plane(0), plane(1), plane(2)};
    q.e = {plane(3), plane(4), plane(5), plane(6), plane(7), plane(8)};
    q.k = plane(9), q.object = rows.object[i], q.sides = rows.sides[i];
    return q;
}

// Sets particle i, without its velocity and not held.
inline void set_particle(ClayRows& rows, std::size_t i, const Particle<float>& q)
{
    const float numbers[clay_planes] = {q.x.x,  q.x.y,  q.x.z,  q.e.xx, q.e.yy,
                                        q.e.zz, q.e.xy, q.e.xz, q.e.yz, q.k};
    for (std::size_t p = 0; p < clay_planes; ++p) rows.planes[p * rows.count + i] = numbers[p];
    rows.object[i] = q.object, rows.sides[i] = q.label();
}

}  // namespace knead
