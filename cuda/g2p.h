// Grid to particle: velocity and its gradient come back; position and strain move on.  (8), (9)
#pragma once
#include "four.h"
#include "stencil.h"

namespace knead {

// velocity(step) is where the memory is: it answers with a Vec3, or with a whole node as a Four
// where that is one register. The sums are factorised: along x, then y, then z.
template <class R, class Velocity>
HD void gather(Particle<R>& q, const Stencil<R>& s, R dx, Velocity&& velocity)
{
    using V = decltype(velocity(Int3{}));
    V sum{}, sum_x{}, sum_y{}, sum_z{};  // of w v, and of w v times the step along x, y, z
    UNROLL
    for (int k = 0; k < 3; ++k) {
        V plane{}, plane_x{}, plane_y{};
        UNROLL
        for (int j = 0; j < 3; ++j) {
            const V first = s.w[0].x * velocity(Int3{0, j, k}),
                    second = s.w[1].x * velocity(Int3{1, j, k}),
                    third = s.w[2].x * velocity(Int3{2, j, k});
            const V row = first + second + third;
            const R w = s.w[j].y;
            plane = plane + w * row;
            plane_x = plane_x + w * (second + R(2) * third);
            plane_y = plane_y + (R(j) * w) * row;
        }
        const R w = s.w[k].z;
        sum = sum + w * plane;
        sum_x = sum_x + w * plane_x;
        sum_y = sum_y + w * plane_y;
        sum_z = sum_z + (R(k) * w) * plane;
    }
    const Vec3<R> v = first_three(sum);
    const R scale = 4 / (dx * dx);
    q.v = v;
    q.C = {scale * (s.d.x * v + dx * first_three(sum_x)),
           scale * (s.d.y * v + dx * first_three(sum_y)),
           scale * (s.d.z * v + dx * first_three(sum_z))};
}

// b <- (I + dt C) b (I + dt C)^T, written for e = b - I so that small strains stay exact:
// e + L e + L =: U, then U + U L^T + L^T, of which six numbers are wanted.  (9)
template <class R>
HD Sym3<R> strained(const Sym3<R>& e, const Mat3<R>& C, R dt)
{
    const Mat3<R> L = dt * C, E = full(e), U = E + L * E + L, rows = transpose(L);
    const auto at = [](R u, Vec3<R> row_u, Vec3<R> row_l, R l) {
        return u + dot(row_u, row_l) + l;
    };
    const Mat3<R> V = transpose(U);  // columns are the rows of U
    return {at(U.a.x, V.a, rows.a, L.a.x), at(U.b.y, V.b, rows.b, L.b.y),
            at(U.c.z, V.c, rows.c, L.c.z), at(U.b.x, V.a, rows.b, L.a.y),
            at(U.c.x, V.a, rows.c, L.a.z), at(U.c.y, V.b, rows.c, L.b.z)};
}

}  // namespace knead
