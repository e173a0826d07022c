// Where a tool may be at any time of a frame.
#pragma once
#include "cuda/contact/skinning.h"

namespace knead {

// Centre and radius of a sphere in the frame's middle. `travel` grows to how far it gets from there
// at most [m]: each of the motions that it is a weighted sum of is farthest at one of the ends.
// from(j), middle(j), to(j) answer with joint j.
template <class R, class From, class Middle, class To>
HD Sphere<R> amid(const Binding<R>& b, From&& from, Middle&& middle, To&& to, R& travel)
{
    R to_end[2] = {0, 0};
    for (int k = 0; k < 4; ++k) {
        if (b.weight[k] == 0) continue;
        const Joint<R> m = middle(b.joint[k]);
        for (int end = 0; end < 2; ++end) {
            const Joint<R> e = end ? to(b.joint[k]) : from(b.joint[k]);
            const R swing = length(rotate(e.q, b.offset[k]) - rotate(m.q, b.offset[k]));
            to_end[end] += b.weight[k] * (length(e.p - m.p) + swing);
        }
    }
    travel = max(travel, max(to_end[0], to_end[1]));
    return {centre(b, middle), {0, 0, 0}, {0, 0, 0}, b.radius, 0};
}

}  // namespace knead
