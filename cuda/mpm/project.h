// Particle projection: pushes particles out of tools and walls.  (19)
#pragma once
#include "cuda/contact/contact.h"
#include "cuda/contact/cut.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/time_step.h"
#include "cuda/mpm/walls.h"

namespace knead {

// Push-out of a particle inside a tool. A displacement would be a deformation that its strain does
// not contain. Therefore its velocity carries it out, and the next scatter transfers the velocity
// to its neighbours; only a particle deeper than `shallow` is displaced immediately, up to that
// depth. Pressure holds a particle at the depth where the push-out speed balances the pressure, so
// it is pushed until its distance from the tool is the skin.  (19)
template <class R>
struct PushoutLimits {
    R shallow;  // under the skin [m]
    R thin;     // under the skin; at half of it, twice the speed is allowed [m]
    R fastest;  // speed limit from there on [m/s]
    R skin;     // [m]
};
// The speed is just below the limit of nodes in the longest substep of clay at rest. A speed that
// grew as substeps get shorter would shorten them further. Clay under pressure lies in a thin
// layer, whose speed reaches nodes in proportion to its share of a cell: there twice the speed is
// safe, and the layer that balances a given pressure is half as thick.
HD PushoutLimits<double> pushout_limits(const StepLimits& limits)
{
    const double dx = limits.dx;
    return {0.375 * dx, dx / 4, 0.9 * dx / longest_dt(limits, {}).dt, dx / 10};
}
template <class To, class From>
HD PushoutLimits<To> cast(const PushoutLimits<From>& pushout)
{
    return {To(pushout.shallow), To(pushout.thin), To(pushout.fastest), To(pushout.skin)};
}

// The part of a particle's speed squared that limits substeps (22). A particle just found in a tool
// does not keep the push-out speed: its neighbours slow it down first.
template <class R>
HD R speed_that_counts(R speed_squared, R depth)
{
    return depth > 0 ? R(0) : speed_squared;
}

// Push-out speed at a depth [m/s]. The particle has to move its neighbours, too, so the speed grows
// with their number per cell; an isolated particle, which has up to 0.21, is not thrown. Depth
// times speed does not fall with depth; else a layer that is too thick would persist.
template <class R>
HD R speed_out(const PushoutLimits<R>& pushout, R depth, R per_cell, R dt)
{
    const R most = min(max(R(1), pushout.thin / depth), min(max(R(1), per_cell), R(2)));
    return min(max(R(1), 4 * per_cell - R(0.7)) * depth / dt, most * pushout.fastest);
}

// Moves x to the surface that it has penetrated, and applies contact to v; the surface advances at
// the additional speed `out`.  (18), (19)
template <class R>
HD void put_out(Vec3<R>& x, Vec3<R>& v, const Contact<R>& hit, const Tool<R>& tool, R out)
{
    const ContactMode mode = tool.mode == ContactMode::slip ? ContactMode::separate : tool.mode;
    x = x - hit.phi * hit.n;
    v = apply_contact(v, hit.n, hit.v + out * hit.n, mode, tool.friction);
}

// Sets x to the position after push-out from `from` towards `to`; returns the distance of the two
// [m].
template <class R>
HD R come_out(Vec3<R>& x, Vec3<R> from, Vec3<R> to, R shallow)
{
    const Vec3<R> all = to - from;
    const R depth = length(all);
    x = depth > shallow ? to - (shallow / depth) * all : from;
    return depth;
}

// Pushes q out of the tools of its block, in at most `passes` iterations; returns its depth under
// the skin [m], 0 outside. `per_cell`: particles per cell around it. Adds these tools to `touched`
// (tool_bit()).
template <class R>
HD R project(Particle<R>& q, const Colliders<R>& c, const Mask& mask, int passes,
             const PushoutLimits<R>& pushout, R per_cell, R dt, std::uint32_t& touched)
{
    Vec3<R> to = q.x;
    for (int k = 0; k < passes; ++k) {
        const Contact<R> hit = deepest_contact(c, mask, to, pushout.skin);
        if (!(hit.phi < 0)) break;
        touched |= tool_bit(hit.tool);
        put_out(to, q.v, hit, c.tools[hit.tool], speed_out(pushout, -hit.phi, per_cell, dt));
    }
    return come_out(q.x, q.x, to, pushout.shallow);
}

// Clamps q to the walls. Returns true if it was deeper than nodes constrained by the walls (18), at
// most one cell per substep, can carry it.  (19)
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

// Labels a particle that a blade has reached, and keeps a labelled one on its side. One further
// across than a substep can have carried it has its label from an older cut: it is relabelled, not
// dragged through the blade. Returns true if a blade covers it; adds its tool to `touched`.
template <class R>
HD bool cut(Particle<R>& q, const Colliders<R>& c, const Mask& mask, R dx, std::uint32_t& touched)
{
    bool covered = false;
    for_each_blade(c, mask, q.x, dx, [&](const Seen<R>& b, const Tool<R>& tool) {
        covered = true;
        touched |= tool_bit(int(&tool - &c.tools[0]));
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

// Whether all values of a particle are finite.
template <class R>
HD bool sound(const Particle<R>& q)
{
    const R sum = q.x.x + q.x.y + q.x.z + q.v.x + q.v.y + q.v.z + trace(q.e) + q.e.xy + q.e.xz +
                  q.e.yz + q.k + determinant(q.C);
    return sum - sum == 0;
}

// Resets a particle with non-finite values to `before`, at rest and without strain: it would
// corrupt 427 neighbours in one substep. Returns true if that was needed.
template <class R>
HD bool repair(Particle<R>& q, const Particle<R>& before)
{
    if (sound(q)) return false;
    q = {before.x, {0, 0, 0}, {}, {}, 0, before.object, before.sides};
    return true;
}

}  // namespace knead
