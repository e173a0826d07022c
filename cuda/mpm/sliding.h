// Friction of clay sliding along a wall, computed from a running mean of the normal force, not from
// its current value.  (18a)
//
// Friction follows a change of pressure with a delay [Prakash 1998]. With instantaneous friction,
// sliding along a wall and oscillation normal to it amplify each other: a sliding elastic body
// vibrates at any resolution, and slides on where it should stop [Ranjith 2001].
#pragma once
#include "cuda/contact/contact.h"
#include "cuda/mpm/walls.h"

namespace knead {

// State of a node whose clay slides along a wall.
template <class R>
struct alignas(16) Sliding {
    R force;            // mean normal force [N]
    R time;             // duration of the slide, at most `sliding_memory` [s]
    int substep;        // the last in which it slid
    R impulse_deficit;  // normal impulse minus the part that friction has acted for [N s]
};

// Window of the mean: time [s], and distance along the wall [cells], since the load on a node comes
// from the clay that passes it.
constexpr double sliding_memory = 0.05, sliding_way = 0.25;

// Index of the Sliding record of node n at a wall normal to `axis`, of normal sign `sign`; -1:
// none.
template <class R>
HD int sliding_place(Int3 n, int axis, int sign, const Walls<R>& walls, Int3 size)
{
    const int at = component(n, axis) - component(walls.first, axis);
    const int layer = sign > 0 ? -at : at - component(walls.free, axis) + 1;
    if (walls.face_places == 0 || unsigned(layer) >= unsigned(sliding_layers)) return -1;
    const int along = axis == 0   ? n.y + size.y * n.z
                      : axis == 1 ? n.x + size.x * n.z
                                  : n.x + size.x * n.y;
    return ((2 * axis + (sign < 0)) * sliding_layers + layer) * walls.face_places + along;
}

// Sliding records in an array, for substep `substep`.
template <class R>
struct SlidingInArray {
    Sliding<R>* all;
    R dx;  // [m]
    int substep;
    HD Sliding<R> get(int place) const { return all[place]; }
    HD void put(int place, const Sliding<R>& s) const { all[place] = s; }
};
// No storage: every substep is the first of a slide.
template <class R>
struct Forgotten {
    R dx = 1;
    int substep = 0;
    HD Sliding<R> get(int) const { return {0, 0, -2, 0}; }
    HD void put(int, const Sliding<R>&) const {}
};

// Applies a wall to a velocity that may still approach it by `approach` [m/s]. `mass`: the mass
// that it stops [kg]; `place`: index of the Sliding record, or -1. (18), (18b): even a slip wall
// does not constrain clay before the clay has reached it. (18a) applies while the clay slides; when
// the clay lifts, the friction of the remaining impulse deficit is applied immediately.
template <class R, class Slides>
HD Vec3<R> apply_friction(Vec3<R> v, Vec3<R> normal, R approach, const Walls<R>& walls, R mass,
                          R dt, int place, const Slides& slides)
{
    const Vec3<R> nearer = -approach * normal;
    const R rising = dot(v, normal), pressing = -rising - approach;
    if (place < 0 || walls.mode != ContactMode::separate || !(mass > 0)) {
        if (approach > 0 && !(pressing > 0)) return v;
        return apply_contact(v, normal, nearer, walls.mode, walls.friction);
    }
    const Sliding<R> before = slides.get(place);
    const bool slid = before.substep == slides.substep - 1;
    const Vec3<R> along = v - rising * normal;
    const R speed = length(along);
    if (!(pressing > 0)) {
        if (!slid || !(before.impulse_deficit > 0)) return v;
        return after_friction(along, speed, rising * normal,
                              walls.friction * before.impulse_deficit / mass);
    }
    const R force = pressing * mass / dt;
    Sliding<R> now{force, dt, slides.substep, 0};
    R mean = pressing;
    if (slid) {
        now.time = min(before.time + dt, R(sliding_memory));
        const R forgets = max(1 / now.time, speed / (R(sliding_way) * slides.dx));  // [1/s]
        const R share = min(dt * forgets, R(1));
        now.force = before.force + share * (force - before.force);
        now.impulse_deficit = before.impulse_deficit + dt * (force - now.force);
        mean = now.force * dt / mass;
    }
    if (speed > walls.friction * mean) slides.put(place, now);
    return after_friction(along, speed, nearer, walls.friction * mean);
}

}  // namespace knead
