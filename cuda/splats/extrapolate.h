// Where something that moves is by the time it is seen, from where it was twice.
#pragma once
#include "cuda/math/vec.h"

namespace knead {

// Where a place, or what became of a neighbourhood, is when it has gone on as it came, by so much
// of its way since before.
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
