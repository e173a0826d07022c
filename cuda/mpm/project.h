// Particle projection: no particle stays inside a tool or behind a wall.  (19)
#pragma once
#include "cuda/contact/contact.h"
#include "cuda/contact/cut.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/walls.h"

namespace knead {

// Moves what is at x, with velocity v, to the surface that it was found behind; what it loses of
// its velocity is what the surface takes.  (18)
template <class R>
HD void put_out(Vec3<R>& x, Vec3<R>& v, const Contact<R>& hit, const Tool<R>& tool)
{
    const ContactMode mode = tool.mode == ContactMode::slip ? ContactMode::separate : tool.mode;
    x = x - hit.phi * hit.n;
    v = apply_contact(v, hit.n, hit.v, mode, tool.friction);
}

// Moves a particle at x with velocity v out of the tools of its block, at most `passes` times.
// Where it was inside of one, tells the depth it was found at [m].
template <class R>
HD void push_out(Vec3<R>& x, Vec3<R>& v, R& depth, const Colliders<R>& c, const Mask& mask,
                 int passes)
{
    for (int k = 0; k < passes; ++k) {
        const Contact<R> hit = deepest_contact(c, mask, x);
        if (!(hit.phi < 0)) break;
        if (k == 0) depth = -hit.phi;
        put_out(x, v, hit, c.tools[hit.tool]);
    }
}

// Of one that was inside, found so deep, the affine part turns rigid, or the next scatter would
// carry it back in.
template <class R>
HD void stiffen(Mat3<R>& C, R depth)
{
    if (depth > 0) C = skew(C);
}

// Both; returns the depth, 0 outside.
template <class R>
HD R project(Particle<R>& q, const Colliders<R>& c, const Mask& mask, int passes)
{
    R depth = 0;
    push_out(q.x, q.v, depth, c, mask, passes);
    stiffen(q.C, depth);
    return depth;
}

// Puts q back on the wall that it sank into; true if it was deeper there than nodes can take it
// that the walls hold (18) and that move by at most a cell per substep.  (19)
template <class R>
HD bool confine(Particle<R>& q, const Walls<R>& walls)
{
    const auto within = [&q](Vec3<R> low, Vec3<R> high) {
        return q.x.x >= low.x && q.x.y >= low.y && q.x.z >= low.z && q.x.x <= high.x &&
               q.x.y <= high.y && q.x.z <= high.z;
    };
    if (within(walls.min, walls.max)) return false;
    const bool escaped = !within(walls.deep_min, walls.deep_max);
    const auto axis = [](R& x, R& v, R low, R high) {
        if (x < low) x = low, v = max(v, R(0));
        if (x > high) x = high, v = min(v, R(0));
    };
    axis(q.x.x, q.v.x, walls.min.x, walls.max.x);
    axis(q.x.y, q.v.y, walls.min.y, walls.max.y);
    axis(q.x.z, q.v.z, walls.min.z, walls.max.z);
    return escaped;
}

// Labels a particle that a blade has reached, and keeps a labelled one on its side. One that lies
// further across than a substep can have carried it has its label from an older cut: it gets
// a new one, and is not dragged through the blade. True if a blade covers it.
template <class R>
HD bool cut(Particle<R>& q, const Colliders<R>& c, const Mask& mask, R dx)
{
    bool covered = false;
    for_each_blade(c, mask, q.x, dx, [&](const Seen<R>& b, const Tool<R>& tool) {
        covered = true;
        const bool astray = (q.sides == below ? b.h : -b.h) > R(0.5) * dx;
        if (q.sides == uncut || astray) q.sides = b.h < 0 ? below : above;
        const R side = q.sides == below ? R(-1) : R(1), inside = b.half - side * b.h;
        if (inside <= 0) return;
        q.x = q.x + (side * inside) * b.n;
        q.v = apply_contact(q.v, side * b.n, b.v, ContactMode::separate, tool.friction);
        q.C = skew(q.C);
    });
    return covered;
}

// Whether all of a particle's numbers are numbers.
template <class R>
HD bool sound(const Particle<R>& q)
{
    const R sum = q.x.x + q.x.y + q.x.z + q.v.x + q.v.y + q.v.z + trace(q.e) + q.e.xy + q.e.xz +
                  q.e.yz + q.k + determinant(q.C);
    return sum - sum == 0;
}

// A particle whose numbers are no longer numbers poisons 427 neighbours in one substep, so it is
// put back, at rest and without strain, where it was. True if that was needed.
template <class R>
HD bool repair(Particle<R>& q, const Particle<R>& before)
{
    if (sound(q)) return false;
    q = {before.x, {0, 0, 0}, {}, {}, 0, before.object, before.sides};
    return true;
}

}  // namespace knead
