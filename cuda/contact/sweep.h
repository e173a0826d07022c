// The space that a tool sweeps during a frame.
#pragma once
#include "cuda/contact/skinning.h"

namespace knead {

// Centre and radius of a sphere at mid-frame, scaled by `size`. Raises `travel` to its largest
// displacement from there [m]: each of the motions in its weighted sum is farthest at one of the
// ends. from(j), middle(j), to(j) return joint j.
template <class R, class From, class Middle, class To>
HD Sphere<R> mid_frame(const Binding<R>& b, Stretch<R> size, From&& from, Middle&& middle, To&& to,
                       R& travel)
{
    Vec3<R> c{};
    R to_end[2] = {0, 0};
    for (int k = 0; k < 4; ++k) {
        if (b.weight[k] == 0) continue;
        const Joint<R> m = middle(b.joint[k]);
        const Vec3<R> o = stretched(b.offset[k], size);
        c = c + b.weight[k] * carried(m, o);
        for (int end = 0; end < 2; ++end) {
            const Joint<R> e = end ? to(b.joint[k]) : from(b.joint[k]);
            const R swing = length(rotate(e.q, o) - rotate(m.q, o));
            to_end[end] += b.weight[k] * (length(e.p - m.p) + swing);
        }
    }
    travel = max(travel, max(to_end[0], to_end[1]));
    return {c, {0, 0, 0}, {0, 0, 0}, size.across * b.radius, 0};
}

}  // namespace knead
