#include "host/verify/cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cuda/mpm/material.h"
#include "host/base/machine.h"
#include "host/solver/audit.h"
#include "host/solver/frame_stats.h"
#include "host/solver/reference.h"

namespace knead {
namespace {

constexpr double gain_bound = 0.05;  // fraction of the energy when the tools come to rest

constexpr double crowded_share = 0.01;  // of the particles

// True if a guard acted, or clay is crowded as defined in a run's report.
bool guarded(const Outcome& o) { return guards_of(o.stats) > 0 || o.crowded > crowded_share; }

std::string guards(const Outcome& o, std::size_t particles)
{
    std::string text;
    const auto say = [&text](const char* name, long count) {
        if (count > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, count);
    };
    for (const auto& [name, count] : frame_guards) say(name, o.stats[count]);
    say("crowded", std::lround(o.crowded * double(particles)));
    return text.empty() ? "no guard" : text;
}

// Checks what must hold for every last state; "": it holds.
std::string broken(const Outcome& o, const Audit& before, const Audit& after, double limit)
{
    if (after.broken > 0) return fmt::format("{} particles without finite numbers", after.broken);
    if (!(std::fabs(after.mass / before.mass - 1) < 1e-9)) return "mass was lost";
    if (!(o.energy_gain <= gain_bound))
        return fmt::format("energy rose by {:.3g} at rest", o.energy_gain);
    if (!(o.fastest <= limit)) return fmt::format("clay at {:.3g} m/s", o.fastest);
    return "";
}

// Energy while nothing acts [J]. It varies within an oscillation, so the maxima of the two halves
// of the interval are compared.
struct Resting {
    double first = -INFINITY, second = -INFINITY, most = 0;
    void see(double energy, bool early)
    {
        double& half = early ? first : second;
        if (!(energy <= half)) half = energy;
        if (!(energy <= most)) most = energy;
    }
    bool seen() const { return first != -INFINITY && second != -INFINITY; }
    double gain() const { return seen() ? (second - first) / std::max(first, 1e-30) : 0; }
    // Speed that indicates an explosion: twice the speed of a hundredth of the clay with all the
    // energy [m/s].
    double bound(const Audit& before) const
    {
        if (!seen()) return INFINITY;
        return 10 * std::sqrt(2 * std::max(first, 0.0) / before.mass) + 20 + 2 * before.fastest;
    }
};

// Fills in the outcome from the last state.
void judge(Outcome& o, const Case& c, const Resting& rest,
           const std::vector<Particle<double>>& last)
{
    const double dx = c.setup.lattice.dx;
    const Audit before = audit(c.setup.particles, c.setup.materials, dx),
                after = audit(last, c.setup.materials, dx);
    const Crowding crowding = knead::crowding(last, c.setup.materials, dx);
    o.fastest = after.fastest, o.volume = after.volume / before.volume;
    o.energy = rest.most, o.energy_gain = rest.gain();
    o.crowded = double(crowding.particles) / double(last.size()), o.densest = crowding.most;
    const bool ended = o.simulated >= c.end - 1e-9;
    std::string wrong = broken(o, before, after, rest.bound(before));
    const double first = energy_of(c.setup.particles, c.setup);
    if (wrong.empty() && c.may_grow > 0 && !(o.energy <= c.may_grow * first))
        wrong = fmt::format("energy rose {:.3g} times", o.energy / first);
    if (wrong.empty() && c.nonsense) wrong = "was taken, and should have been refused";
    if (wrong.empty() && ended && !guarded(o)) wrong = silent_error(c.setup, before, after);
    const std::string seen = guards(o, last.size());
    o.note = wrong.empty() ? seen : wrong + "; " + seen;
    o.ending = !wrong.empty() ? Ending::failed
               : !ended       ? Ending::slow
               : guarded(o)   ? Ending::guarded
                              : Ending::stable;
}

}  // namespace

const char* ending_name(Ending e)
{
    const char* const names[] = {"stable", "guarded", "slow", "refused", "FAILED"};
    return names[int(e)];
}

std::string silent_error(const Setup& s, const Audit& before, const Audit& after)
{
    double yield = 0, bulk = INFINITY, rest = 0;
    for (const Particle<double>& q : s.particles) rest += s.materials[std::size_t(q.object)].volume;
    for (const Material<double>& m : s.materials) {
        if (m.plasticity == Plasticity::drucker_prager || m.plasticity == Plasticity::clamp)
            return "";
        bulk = std::min(bulk, m.bulk);
        if (m.plasticity != Plasticity::none && m.plasticity != Plasticity::fluid)
            yield = std::max(yield, m.yield);
    }
    const double weight = after.mass / rest * length(s.gravity) * std::cbrt(rest);
    const double given = std::sqrt(2 * (before.elastic + after.kinetic) / (bulk * rest));
    const double off = after.volume / rest - 1, bound = 0.02 + (yield + 2 * weight) / bulk + given;
    if (std::fabs(off) <= bound) return "";
    return fmt::format("silent: volume is off by {:.2g} %, and {:.2g} % are explained", 100 * off,
                       100 * bound);
}

double energy_of(const std::vector<Particle<double>>& all, const Setup& s)
{
    double sum = 0;
    for (const Particle<double>& q : all) {
        const Material<double>& m = s.materials[std::size_t(q.object)];
        sum += m.volume * stored_energy(q, m) + 0.5 * m.mass * dot(q.v, q.v) +
               affine_energy(q.C, m.mass, s.lattice.dx) -
               m.mass * dot(s.gravity, q.x - floor_of(s));
    }
    return sum;
}

Outcome outcome_of(const Verification& v, const Case& c, double limit, bool in_double)
{
    const double begun = wall_seconds();
    const auto spent = [&] { return wall_seconds() - begun; };
    Outcome o;
    Resting rest;
    try {
        const auto solver = in_double ? v.reference(c.setup) : v.solver(c.setup);
        double& t = o.simulated;
        while (t < c.end - 1e-9 && spent() < limit) {
            const bool acts = t < c.action - 1e-9;
            const double to = std::min(t + c.frame, acts ? c.action : c.end);
            Motion motion;
            if (c.at) motion.from = c.at(t), motion.to = c.at(to);
            if (c.active) motion.active = c.active(t);
            add_to(o.stats, solver->advance(motion, to - t));
            t = to;
            if (t >= c.action - 1e-9)
                rest.see(energy_of(solver->particles(), c.setup), t < (c.action + c.end) / 2);
        }
        judge(o, c, rest, solver->particles());
    } catch (const std::bad_alloc&) {
        o.note = "out of memory";
    } catch (const std::exception& e) {
        o.ending = o.simulated > 0 ? Ending::failed : Ending::refused, o.note = e.what();
    }
    o.seconds = spent();
    return o;
}

void change(Verification& v, std::unique_ptr<Simulator>& solver, const Setup& s,
            const std::function<void(std::vector<Particle<double>>&)>& how)
{
    EditableSimulator* editable = solver->editable();
    if (!editable) {  // the Reference, whose whole state are its particles
        Setup now = s;
        now.particles = solver->particles();
        how(now.particles);
        solver = v.reference(now);
        return;
    }
    SavedState state = editable->save();
    how(state.contents.particles);
    editable->load(state);
}

Setup block_on_floor(const Material<double>& material, int per_axis)
{
    constexpr double dx = 0.01;
    Setup s = between_walls({16, 16, 16}, dx, ContactMode::separate, 0.3);
    s.gravity = {0, -9.81, 0};
    const Place floor = floor_of(s), reach{3 * dx, 0, 3 * dx};
    fill(s, material, floor - reach, floor + reach + Place{0, 4 * dx, 0}, per_axis);
    return s;
}

Case pressed_block(std::string name, const Material<double>& material, double radius, double speed,
                   double depth, int per_axis)
{
    Case c{std::move(name), block_on_floor(material, per_axis)};
    add_ball_tool(c.setup, radius, ContactMode::separate, 0.3);
    const double dx = c.setup.lattice.dx, start = radius + 0.5 * dx;
    const double down = (0.5 * dx + depth) / speed;
    const Place axis = floor_of(c.setup) + Place{0.13 * dx, 4 * dx, -0.21 * dx};
    c.at = [=](double t) {
        const double way = t < down ? speed * t : std::max(2 * speed * down - speed * t, 0.0);
        return std::vector{stands_at(axis + Place{0, start - way, 0})};
    };
    c.action = 2 * down;
    c.end = c.action + std::min(0.1, 1000 * 0.4 * dx / sound_speed(material));
    c.frame = std::min(c.frame, down / 4);
    return c;
}

}  // namespace knead
