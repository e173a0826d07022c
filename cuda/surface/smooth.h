// Smoothing and shading of a closed triangle mesh, per vertex and its ring.
#pragma once
#include "cuda/math/vec.h"

namespace knead {

// Factors of the umbrella operator. At 1/2 the sharpest ripple, whose eigenvalue is 2, is removed
// in one step without overshoot. Taubin's second step inflates what the first has shrunk: the shape
// is unchanged below the eigenvalue 1 / shrink + 1 / swell = 0.11.  [Taubin 1995]
template <class R>
constexpr R smooth_shrink = R(0.5);
template <class R>
constexpr R smooth_swell = R(-0.53);

// Moves a vertex by `factor` of the displacement to the mean of its neighbours; neighbour(k)
// returns their positions before the step.
template <class R, class Neighbour>
HD Vec3<R> relax(Vec3<R> x, int count, R factor, Neighbour&& neighbour)
{
    if (count == 0) return x;
    Vec3<R> sum{};  // of the differences: far from the origin the positions would lose digits
    for (int k = 0; k < count; ++k) sum = sum + (neighbour(k) - x);
    return x + (factor / R(count)) * sum;
}

// Twice the area of a triangle, along its outward normal [m^2].
template <class R>
HD Vec3<R> area_normal(Vec3<R> a, Vec3<R> b, Vec3<R> c)
{
    return cross(b - a, c - a);
}

// Unit normal of a vertex from its `count` triangles, weighted by area; area(k) returns the
// area_normal of one. Upright if all areas are zero.
template <class R, class Area>
HD Vec3<R> vertex_normal(int count, Area&& area)
{
    Vec3<R> sum{};
    for (int k = 0; k < count; ++k) sum = sum + area(k);
    const R largest = max(max(std::abs(sum.x), std::abs(sum.y)), std::abs(sum.z));
    if (!(largest > 0)) return {0, 1, 0};
    const Vec3<R> n = (1 / largest) * sum;  // squares of square millimetres underflow float
    return (1 / length(n)) * n;
}

}  // namespace knead
