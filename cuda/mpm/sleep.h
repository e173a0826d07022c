// Sleep: clay at rest is not simulated. A block is asleep if it has been at rest for a while and is
// far from every tool; in localized mode, if it is outside boxes around the tools. Still clay next
// to moving clay scatters its mass and stress, so that it supports its neighbours; it wakes if it
// is pushed.  (29), (30)
#pragma once
#include "cuda/math/box.h"
#include "cuda/mpm/material_data.h"
#include "cuda/mpm/particle.h"

namespace knead {

enum class RestMode : int { none, sleep, localized };

template <class R>
struct Rest {
    RestMode mode;
    R speed;     // slower clay is at rest [m/s]
    int frames;  // consecutive frames at rest before it falls asleep
    R push;      // still clay wakes above this acceleration [m/s^2]
    R reach;     // margin of the boxes around the tools [m]
};

// Activity of a block of nodes in a frame; in sleep mode neighbours differ by at most one.
enum Activity : int {
    asleep,   // not simulated
    support,  // still: scatters mass and stress
    guard,    // as support, and wakes if pushed; all its neighbours are at least support
    awake,    // moves
    moving    // moved lately or is near a tool: its neighbours are awake
};

constexpr int never = 0x7fffffff;

// Consecutive frames at rest of a block, after a frame in which its largest speed squared was
// `speed_squared` [m^2/s^2].
template <class R>
HD int rested(const Rest<R>& rest, int frames, R speed_squared)
{
    if (!(speed_squared < rest.speed * rest.speed)) return 0;
    return frames < rest.frames ? frames + 1 : frames;
}

// Activity of a block by itself, before its neighbours are considered.
template <class R>
HD int own_activity(const Rest<R>& rest, int frames, bool near_tool)
{
    if (rest.mode == RestMode::localized) return near_tool ? awake : asleep;
    return near_tool || frames < rest.frames ? moving : asleep;
}

// Minimum activity of the neighbours of a block with this `activity`. Applied for moving, awake and
// guard in this order.
template <class R>
HD int neighbour_of(const Rest<R>& rest, int activity)
{
    return rest.mode == RestMode::localized ? support : activity - 1;
}

// Whether still clay must move; v is the velocity that the grid would give it in a substep of dt
// [s].  (30)
template <class R>
HD bool pushed(const Rest<R>& rest, Vec3<R> v, R dt)
{
    const R max = rest.push * dt;
    return dot(v, v) > max * max;
}

// Localized mode: held clay is an obstacle to moving clay. It is scattered with held_weight times
// its mass, and with the velocity that cancels gravity in a substep of dt [s], so that the nodes
// around it stay at rest under any load.  (30a)
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

// Whether a block, given by its coordinates, overlaps the box.
template <class R>
HD bool meets(const Box3<R>& box, Int3 block, R edge)
{
    const Vec3<R> low = {edge * R(block.x), edge * R(block.y), edge * R(block.z)};
    return intersects({low, low + Vec3<R>{edge, edge, edge}}, box);
}

}  // namespace knead
