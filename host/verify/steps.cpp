// stability: effect of the substep length: every preset with the default and a quarter of it, and
// the margin above the default.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/scene/presets.h"
#include "host/verify/cases.h"

namespace knead {
namespace {

constexpr double cell = 0.01;  // [m]
constexpr double limit = 120;  // wall time limit of a run [s]

}  // namespace

void steps_part(Verification& v)
{
    double gain = 0;
    std::string who;
    for (const std::string& name : preset_names()) {
        Case c = pressed_block(name, preset(name), 2 * cell, 0.5, 2 * cell);
        if (v.quick()) c.end = c.action + (c.end - c.action) / 4;
        const Outcome whole = outcome_of(v, c, limit);
        c.setup.step.fixed = whole.stats.dt_min / 4;
        const Outcome quarter = outcome_of(v, c, limit);
        Check check = near(fmt::format("{}: volume after a press, dt against dt/4", name),
                           100 * whole.volume, 100 * quarter.volume, 2, "%",
                           "volume depends on the substep: compare runs of one step.courant only");
        check.note = fmt::format("{} and {} substeps; {}, {}", whole.stats.substeps,
                                 quarter.stats.substeps, whole.note, quarter.note);
        if (whole.ending == Ending::failed || quarter.ending == Ending::failed)
            check.verdict = Verdict::failed;
        v.add(check);
        if (!(whole.energy_gain <= gain)) gain = whole.energy_gain, who = name;
    }
    Check c = at_most("presets: energy gained while tools stand still", 100 * gain, 1, "%",
                      "lower step.courant for the named preset");
    c.note = who;
    v.add(c);
}

namespace {

Case ringing(const char* name, double nu, bool alone)
{
    Case c{name, between_walls({16, 16, 16}, cell, ContactMode::separate, 0)};
    const Place middle = c.setup.walls.min + Place{8.2 * cell, 8.4 * cell, 8.1 * cell};
    fill(c.setup, elastic(1e5, nu, 1000), c.setup.walls.min, c.setup.walls.max, 2,
         [&](Place x) { return length(x - middle) < 3 * cell; });
    if (alone) c.setup.particles.resize(1), c.setup.particles[0].x = middle;
    const double s = alone ? 0.01 : 0.005;
    for (Particle<double>& q : c.setup.particles) q.e = {s, s, s, 0, 0, 0};
    const double sound =
        std::sqrt((c.setup.materials[0].lambda + 2 * c.setup.materials[0].mu) / 1000);
    // Just below the stability limit a particle's energy, sampled once per substep, oscillates by
    // an order of magnitude; above it, it grows without bound.
    c.may_grow = alone ? 20 : 3;
    c.end = 2000 * 0.4 * cell / sound, c.frame = c.end / 100;
    return c;
}

// The longest substep without failure, as a multiple of the default.
double margin_of(const Verification& v, const Case& c, std::string& why)
{
    double held = 0, energy = 0;
    for (const double times : substep_ladder) {
        const Outcome o = outcome_alone(v, with_substep(c, times));
        if (held == 0) energy = o.energy;
        const bool lively = c.may_grow == 0 && !(o.energy <= 2 * energy);
        if (o.ending == Ending::failed || o.ending == Ending::refused || lively) {
            why = fmt::format("at {} times: {}{}", times,
                              lively ? "more than twice the energy of the default; " : "", o.note);
            break;
        }
        if (o.ending == Ending::guarded && why.empty())
            why = fmt::format("guards act from {} times on", times);
        held = times;
    }
    return held;
}

}  // namespace

const std::vector<double> substep_ladder{1, 1.25, 1.5, 1.75, 2, 2.5, 3};

Case with_substep(Case c, double times)
{
    c.setup.step.courant *= times;
    c.name += fmt::format(", {} times the substep", times);
    return c;
}

std::vector<Case> margin_cases(bool quick)
{
    std::vector<Case> cases{ringing("ball that rings, nu = 0.3", 0.3, false),
                            ringing("ball that rings, nu = 0.49", 0.49, false),
                            ringing("ball that rings, nu = 0.499", 0.499, false),
                            ringing("lone particle, nu = 0.3", 0.3, true),
                            ringing("lone particle, nu = 0.49", 0.49, true)};
    for (const char* name : {"clay", "jelly", "dough"})
        if (!quick || name[0] == 'j')
            cases.push_back(pressed_block(fmt::format("{} pressed", name), preset(name), 2 * cell,
                                          0.5, 2 * cell));
    for (Case& c : cases) c.limit = limit;
    return cases;
}

void margin_part(Verification& v)
{
    for (const Case& c : margin_cases(v.quick())) {
        std::string why;
        const double held = margin_of(v, c, why);
        Check check = at_least(fmt::format("margin of the substep: {}", c.name), held, 1.5,
                               "x default", "set step.courant to a share below the margin / 1.5");
        check.note = why;
        v.add(check);
    }
}

}  // namespace knead
