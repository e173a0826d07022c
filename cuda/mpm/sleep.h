// Clay that need not move. Asleep lies what has been at rest for a while and is far from every
// tool; or, in the localized mode, all that lies outside of boxes around the tools. Around what
// moves, clay that stays still gives its mass and stress to the lattice, so that it carries its
// neighbours; what is pushed there wakes.  (29), (30)
#pragma once
#include "cuda/math/vec.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"

namespace knead {

enum class RestMode : int { none, sleep, localized };

template <class R>
struct Rest {
    RestMode mode;
    R speed;     // slower clay is at rest [m/s]
    int frames;  // for so many on end, before it falls asleep
    R push;      // still clay wakes where it would be accelerated by more [m/s^2]
    R reach;     // how far boxes reach beyond the tools [m]
};

// What the clay of a block of nodes does in a frame; each is next to the one above it.
enum Activity : int {
    asleep,   // nothing
    support,  // still: gives mass and stress to the lattice
    guard,    // the same, and wakes where it is pushed: all its neighbours are at least support
    awake,    // moves
    moving    // moves, and must have been: its neighbours are awake
};

constexpr int never = 0x7fffffff;

// How many frames on end a block's clay has been at rest, after one in which its fastest had this
// speed squared [m^2/s^2].
template <class R>
HD int rested(const Rest<R>& rest, int frames, R speed_squared)
{
    if (!(speed_squared < rest.speed * rest.speed)) return 0;
    return frames < rest.frames ? frames + 1 : frames;
}

// What a block does of itself, before its neighbours are asked.
template <class R>
HD int own_activity(const Rest<R>& rest, int frames, bool near_tool)
{
    if (rest.mode == RestMode::localized) return near_tool ? awake : asleep;
    return near_tool || frames < rest.frames ? moving : asleep;
}

// What a block makes of its neighbours at least; asked of moving, awake and guard in this order.
template <class R>
HD int neighbour_of(const Rest<R>& rest, int activity)
{
    return rest.mode == RestMode::localized ? support : activity - 1;
}

// Whether clay that lies still must move: v is what the lattice would have given it in a substep of
// dt [s].  (30)
template <class R>
HD bool pushed(const Rest<R>& rest, Vec3<R> v, R dt)
{
    const R max = rest.push * dt;
    return dot(v, v) > max * max;
}

// In the localized mode clay that is held stands in the way of what moves: so do the nodes around
// it, whatever pushes them, for to them it weighs so many times what it does, and rises as fast as
// gravity lets it fall in a substep of dt [s].  (30a)
constexpr double held_weight = 1000;
template <class R>
HD bool stands(RestMode mode, const Particle<R>& q)
{
    return mode == RestMode::localized && q.still();
}
template <class R>
HD Material<R> as_held(Material<R> m)
{
    m.mass *= R(held_weight);
    return m;
}
template <class R>
HD Vec3<R> held_rise(Vec3<R> gravity, R dt)
{
    return -dt * gravity;
}

// Two corners of a box along the axes [m].
template <class R>
struct AxisBox {
    Vec3<R> low, high;
};

// Whether a block, by its coordinates, lies in the box at least in part.
template <class R>
HD bool meets(const AxisBox<R>& box, Int3 block, R edge)
{
    const Vec3<R> low = {edge * R(block.x), edge * R(block.y), edge * R(block.z)};
    return low.x <= box.high.x && low.y <= box.high.y && low.z <= box.high.z &&
           low.x + edge >= box.low.x && low.y + edge >= box.low.y && low.z + edge >= box.low.z;
}

}  // namespace knead
