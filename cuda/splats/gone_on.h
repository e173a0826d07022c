// Where something that moves is by the time it is seen, from where it was twice.
#pragma once
#include "cuda/math/vec.h"

namespace knead {

// Where a place, or what became of a neighbourhood, is when it has gone on as it came, by so much
// of its way since before.
template <class R>
HD Vec3<R> gone_on(Vec3<R> now, Vec3<R> before, R ahead)
{
    return now + ahead * (now - before);
}
template <class R>
HD Mat3<R> gone_on(const Mat3<R>& now, const Mat3<R>& before, R ahead)
{
    return {gone_on(now.a, before.a, ahead), gone_on(now.b, before.b, ahead),
            gone_on(now.c, before.c, ahead)};
}

}  // namespace knead
