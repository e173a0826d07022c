// Linear extrapolation of motion to the time of display.
#pragma once
#include "cuda/math/vec.h"

namespace knead {

// Extrapolates a position or a deformation gradient by the fraction `extrapolation` of its last
// change.
template <class R>
HD Vec3<R> extrapolated(Vec3<R> now, Vec3<R> before, R extrapolation)
{
    return now + extrapolation * (now - before);
}
template <class R>
HD Mat3<R> extrapolated(const Mat3<R>& now, const Mat3<R>& before, R extrapolation)
{
    return {extrapolated(now.a, before.a, extrapolation),
            extrapolated(now.b, before.b, extrapolation),
            extrapolated(now.c, before.c, extrapolation)};
}

}  // namespace knead
