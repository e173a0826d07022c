// Grid to particle: velocity and its gradient come back; position and strain move on.  (8), (9)
#pragma once
#include "stencil.h"

namespace knead {

// velocity(step) is where the memory is. The sums are factorised: along x, then y, then z.
template <class R, class Velocity>
HD void gather(Particle<R>& q, const Stencil<R>& s, R dx, Velocity&& velocity)
{
    Vec3<R> v{}, vx{}, vy{}, vz{};  // sum of w v, and of w v times the step along x, y, z
    UNROLL
    for (int k = 0; k < 3; ++k) {
        Vec3<R> plane{}, plane_x{}, plane_y{};
        UNROLL
        for (int j = 0; j < 3; ++j) {
            const Vec3<R> first = s.w[0].x * velocity(Int3{0, j, k}),
                          second = s.w[1].x * velocity(Int3{1, j, k}),
                          third = s.w[2].x * velocity(Int3{2, j, k});
            const Vec3<R> row = first + second + third;
            const R w = s.w[j].y;
            plane = plane + w * row;
            plane_x = plane_x + w * (second + R(2) * third);
            plane_y = plane_y + (R(j) * w) * row;
        }
        const R w = s.w[k].z;
        v = v + w * plane;
        vx = vx + w * plane_x;
        vy = vy + w * plane_y;
        vz = vz + (R(k) * w) * plane;
    }
    const R scale = 4 / (dx * dx);
    q.v = v;
    q.C = {scale * (s.d.x * v + dx * vx), scale * (s.d.y * v + dx * vy),
           scale * (s.d.z * v + dx * vz)};
}

// b <- (I + dt C) b (I + dt C)^T, written for e = b - I so that small strains stay exact.  (9)
template <class R>
HD Sym3<R> strained(const Sym3<R>& e, const Mat3<R>& C, R dt)
{
    const Mat3<R> L = dt * C, E = full(e), T = E + L * E, Lt = transpose(L);
    return symmetric(T + T * Lt + L + Lt + L * Lt);
}

}  // namespace knead
