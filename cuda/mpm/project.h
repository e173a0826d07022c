// Particle projection: no particle stays deep inside a tool, or behind a wall.  (19)
#pragma once
#include "cuda/contact/contact.h"
#include "cuda/contact/cut.h"
#include "cuda/mpm/lattice.h"
#include "cuda/mpm/particle.h"
#include "cuda/mpm/time_step.h"
#include "cuda/mpm/walls.h"

namespace knead {

// How a particle inside a tool gets out. Moving it would be deformation that the strain never hears
// of, so its velocity is to carry it out, and the next scatter tells its neighbours; only what lies
// deeper than `shallow` is moved at once, up to there. Pressure holds it as deep as the speed out
// balances it, so it is sent on until it is the skin away from the tool.  (19)
template <class R>
struct PushoutLimits {
    R shallow;  // under the skin [m]
    R thin;     // under the skin; half as deep, it may be twice as fast [m]
    R fastest;  // from there on [m/s]
    R skin;     // [m]
};
// The speed is just less than nodes may have in the longest substep of clay at rest. If it grew
// where substeps are shorter, it would make them shorter still. What is pressed lies in a thin
// layer, and nodes hear of its speed by its share of a cell: there twice as much is no danger, and
// the layer that balances a pressure is half as thick.
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

// What of a particle's speed squared shortens substeps (22). What has just been found in a tool
// will not move at the speed that it was given: those around it slow it down first.
template <class R>
HD R speed_that_counts(R speed_squared, R depth)
{
    return depth > 0 ? R(0) : speed_squared;
}

// The speed at which it leaves from that depth [m/s]. It has to move those around it, too, so this
// grows with their number a cell; a crumb by itself, which has up to 0.21, is not thrown. Depth
// times speed does not fall as depth grows, or a layer once too thick would stay.
template <class R>
HD R speed_out(const PushoutLimits<R>& pushout, R depth, R per_cell, R dt)
{
    const R most = min(max(R(1), pushout.thin / depth), min(max(R(1), per_cell), R(2)));
    return min(max(R(1), 4 * per_cell - R(0.7)) * depth / dt, most * pushout.fastest);
}

// Moves what is at x, with velocity v, to the surface that it was found behind; its velocity is
// what the surface leaves of it that comes out at speed `out`, too.  (18), (19)
template <class R>
HD void put_out(Vec3<R>& x, Vec3<R>& v, const Contact<R>& hit, const Tool<R>& tool, R out)
{
    const ContactMode mode = tool.mode == ContactMode::slip ? ContactMode::separate : tool.mode;
    x = x - hit.phi * hit.n;
    v = apply_contact(v, hit.n, hit.v + out * hit.n, mode, tool.friction);
}

// What was found at `from` and belongs to `to` is at x now; returns how far that is [m].
template <class R>
HD R come_out(Vec3<R>& x, Vec3<R> from, Vec3<R> to, R shallow)
{
    const Vec3<R> all = to - from;
    const R depth = length(all);
    x = depth > shallow ? to - (shallow / depth) * all : from;
    return depth;
}

// Brings q out of the tools of its block, looking for them `passes` times at most; returns how
// deep under the skin it was found [m], 0 outside. A cell around it holds `per_cell` like q. Those
// tools are added to `touched` (tool_bit()).
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
// a new one, and is not dragged through the blade. True if a blade covers it; its tool is added to
// `touched`.
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
