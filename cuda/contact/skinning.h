// From joints to medial spheres: each sphere is bound to up to four joints by weights, so shared
// spheres never tear. Poses, never distance fields, are interpolated between frames.  (20), (21)
#pragma once
#include "cuda/contact/medial.h"

namespace knead {

// Pose of a joint. OpenXR: +z backwards along the bone, +y out of the back.
template <class R>
struct Joint {
    Quat<R> q;  // unit
    Vec3<R> p;  // [m]
};

// One medial sphere in the frames of its joints.
template <class R>
struct Binding {
    int joint[4];       // unused ones: any joint, with weight 0
    R weight[4];        // sum 1; the first is the largest
    Vec3<R> offset[4];  // of the centre, in that joint's frame [m]
    R radius;           // [m]
};

// Scale of a bound tool relative to its rig: across a bone (local x and y, and radii), and along it
// (local z).
template <class R>
struct Stretch {
    R across = 1, along = 1;
};

template <class To, class From>
HD Joint<To> cast(const Joint<From>& j)
{
    return {cast<To>(j.q), cast<To>(j.p)};
}
template <class To, class From>
HD Binding<To> cast(const Binding<From>& b)
{
    Binding<To> c{};
    for (int k = 0; k < 4; ++k)
        c.joint[k] = b.joint[k], c.weight[k] = To(b.weight[k]), c.offset[k] = cast<To>(b.offset[k]);
    c.radius = To(b.radius);
    return c;
}
template <class To, class From>
HD Stretch<To> cast(const Stretch<From>& s)
{
    return {To(s.across), To(s.along)};
}

// An offset in a joint's frame, and a binding, scaled.
template <class R>
HD Vec3<R> stretched(Vec3<R> offset, Stretch<R> s)
{
    return {s.across * offset.x, s.across * offset.y, s.along * offset.z};
}
template <class R>
HD Binding<R> stretched(Binding<R> b, Stretch<R> s)
{
    for (int k = 0; k < 4; ++k) b.offset[k] = stretched(b.offset[k], s);
    b.radius *= s.across;
    return b;
}

// Interpolates between two poses; s in [0, 1].
template <class R>
HD Joint<R> between(const Joint<R>& from, const Joint<R>& to, R s)
{
    return {between(from.q, to.q, s), from.p + s * (to.p - from.p)};
}

// Transforms an offset in the joint's frame to a position.
template <class R>
HD Vec3<R> carried(const Joint<R>& j, Vec3<R> offset)
{
    return j.p + rotate(j.q, offset);
}

// The sphere's centre; pose(j) returns joint j.
template <class R, class Pose>
HD Vec3<R> centre(const Binding<R>& b, Pose&& pose)
{
    Vec3<R> c{};
    for (int k = 0; k < 4; ++k) {
        if (b.weight[k] == 0) continue;
        c = c + b.weight[k] * carried<R>(pose(b.joint[k]), b.offset[k]);
    }
    return c;
}

// Angular velocity [1/s] that rotates p to q over `duration` [s].
template <class R>
HD Vec3<R> spin(Quat<R> p, Quat<R> q, R duration)
{
    Quat<R> d = q * conjugate(p);
    if (d.w < 0) d = {-d.w, -d.x, -d.y, -d.z};
    const R s = 2 / duration;  // small turns: 2 sin(angle / 2) is the angle to its cube / 24
    return {s * d.x, s * d.y, s * d.z};
}

// The sphere in a substep of dt: at `to`, with the velocity that moves it exactly from `from` to
// `to`; its radius is scaled by `size`.
template <class R, class From, class To>
HD Sphere<R> posed(const Binding<R>& b, From&& from, To&& to, R dt, R size)
{
    const Vec3<R> c0 = centre(b, from), c1 = centre(b, to);
    return {c1, (1 / dt) * (c1 - c0), spin(from(b.joint[0]).q, to(b.joint[0]).q, dt),
            size * b.radius, 0};
}

}  // namespace knead
