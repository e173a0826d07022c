// stability: a map of stiff and extreme cases, and how each of them ends.
#include <fmt/format.h>

#include <cmath>

#include "host/scene/presets.h"
#include "host/verify/cases.h"

namespace knead {
namespace {

constexpr double cell = 0.01;  // [m]

Material<double> clay_of(double young, double poisson)
{
    return plastic(young, poisson, 1600, young / 30);
}
const Material<double> usual = clay_of(3e5, 0.4);

void add_materials(std::vector<Case>& all, bool quick)
{
    for (const std::string& name : preset_names())
        all.push_back(pressed_block("preset " + name, preset(name), 2 * cell, 0.5, 2 * cell));
    for (const double E : {1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9})
        for (const double nu : {0.0, 0.3, 0.45, 0.49, 0.499}) {
            const bool corner = (E == 1e3 || E == 1e6 || E == 1e9) && nu != 0.3 && nu != 0.45;
            if (quick && !corner) continue;
            const Case c = pressed_block(fmt::format("E = {:.0e} Pa, nu = {}", E, nu),
                                         clay_of(E, nu), 2 * cell,
                                         E > 1e7   ? 10
                                         : E > 1e5 ? 2
                                                   : 0.5,
                                         2 * cell);
            all.push_back(c);
        }
    for (const double density : {10.0, 100.0, 2e4}) {
        if (quick && density == 100) continue;
        Material<double> m = usual;
        m.density = density;
        all.push_back(
            pressed_block(fmt::format("density {} kg/m^3", density), m, 2 * cell, 0.5, 2 * cell));
    }
    for (const int per_axis : {1, 3, 4}) {
        if (quick && per_axis == 3) continue;
        all.push_back(
            pressed_block(fmt::format("{} particles a cell", per_axis * per_axis * per_axis), usual,
                          2 * cell, 0.5, 2 * cell, per_axis));
    }
}

void add_tools(std::vector<Case>& all, bool quick)
{
    for (const double speed : {0.1, 1.0, 3.0, 10.0})
        if (!quick || speed > 1)
            all.push_back(pressed_block(fmt::format("tool at {} m/s", speed), usual, 2 * cell,
                                        speed, 3 * cell));
    for (const double radius : {0.1, 0.25, 0.5, 1.0, 4.0})
        if (!quick || radius == 0.1 || radius == 4)
            all.push_back(pressed_block(fmt::format("tool of {} dx", radius), usual, radius * cell,
                                        0.5, std::min(4 * radius, 3.0) * cell));
    for (const char* name : {"clay", "jelly", "wet-sand", "snow"})
        if (!quick || name[0] != 'w')
            all.push_back(pressed_block(fmt::format("{} pressed to one cell", name), preset(name),
                                        40 * cell, 0.5, 3 * cell));
    Case jumps = pressed_block("a tool that jumps 12 dx at a time", usual, 2 * cell, 0.5, 0);
    const Place floor = floor_of(jumps.setup);
    jumps.at = [floor](double t) {
        const int hop = int(std::min(t, 0.1) * 90 + 0.5);
        return std::vector{stands_at(floor + Place{hop % 2 ? 6 * cell : -6 * cell, 2 * cell, 0})};
    };
    jumps.action = 0.1, jumps.end = 0.2;
    all.push_back(jumps);
    Case lost = pressed_block("a tool lost and found in the clay", usual, 2 * cell, 0.5, 3 * cell);
    lost.active = [](double t) { return std::vector<char>{char(int(t * 90 + 0.5) % 3 != 1)}; };
    lost.end = lost.action + 0.1;
    all.push_back(lost);
    Case crossing = pressed_block("two tools that cross in the clay", usual, 2 * cell, 1, 0);
    add_ball_tool(crossing.setup, 2 * cell, ContactMode::sticky, 0.3);
    crossing.at = [floor](double t) {
        const double x = 6 * cell - 1 * std::min(t, 0.12);
        return std::vector{stands_at(floor + Place{x, 2 * cell, 0}),
                           stands_at(floor + Place{-x, 2 * cell, 0})};
    };
    crossing.action = 0.12, crossing.end = 0.22;
    all.push_back(crossing);
}

// Clay that is let go.
Case released(std::string name, Setup s, double end = 0.15)
{
    Case c{std::move(name), std::move(s)};
    c.end = end, c.frame = 1.0 / 360;
    return c;
}

// A ball of 3 cells radius in the middle of the air.
Setup ball_in_air(const Material<double>& material)
{
    Setup s = between_walls({24, 24, 24}, cell, ContactMode::separate, 0.3);
    const Place middle = s.walls.min + Place{12 * cell, 12 * cell, 12 * cell};
    fill(s, material, s.walls.min, s.walls.max, 2,
         [&](Place x) { return length(x - middle) < 3 * cell; });
    return s;
}

void set_strain(Setup& s, Vec3<double> stretch)
{
    for (Particle<double>& q : s.particles)
        q.e = {stretch.x * stretch.x - 1,
               stretch.y * stretch.y - 1,
               stretch.z * stretch.z - 1,
               0,
               0,
               0};
}

void add_violence(std::vector<Case>& all)
{
    const Material<double> jelly = elastic(1e4, 0.45, 1050);
    for (const auto& [name, m] : {std::pair{"clay", usual}, std::pair{"jelly", jelly}}) {
        Setup s = ball_in_air(m);
        for (Particle<double>& q : s.particles) q.v = {30, 0, 0};
        all.push_back(released(fmt::format("{} thrown at a wall at 30 m/s", name), s, 0.05));
        s = ball_in_air(m);
        const Place middle = s.walls.min + Place{12 * cell, 12 * cell, 12 * cell};
        for (Particle<double>& q : s.particles) q.v = {400 * (q.x.x - middle.x), 0, 0};
        all.push_back(released(fmt::format("{} torn apart at 400 1/s", name), s));
    }
    Setup s = ball_in_air(jelly);
    set_strain(s, {10, 0.31623, 0.31623});
    all.push_back(released("jelly stretched 10 times, let go", s));
    s = ball_in_air(jelly);
    set_strain(s, {0.3, 0.3, 0.3});
    all.push_back(released("jelly at 1/37 of its volume, let go", s));
}

void add_crumbs(std::vector<Case>& all)
{
    const Material<double> jelly = elastic(1e6, 0.45, 1050);
    Setup s = ball_in_air(usual);
    s.particles.resize(1);
    s.gravity = {0, -9.81, 0};
    all.push_back(released("a single particle falls", s, 0.3));
    s = ball_in_air(jelly);
    s.particles.resize(1);
    set_strain(s, {1.05, 1.05, 1.05});
    all.push_back(released("a single particle rings", s, 0.1));
    for (const double spread : {1.0, 0.0}) {
        s = ball_in_air(usual);
        const Place corner = s.walls.min + Place{12.2 * cell, 12.1 * cell, 12.3 * cell};
        s.particles.clear();
        for (int i = 0; i < 1000; ++i) {
            Particle<double> q{};
            q.x = corner + (0.9 * spread / 10 * cell) *
                               Place{double(i % 10), double(i / 10 % 10), double(i / 100)};
            s.particles.push_back(q);
        }
        all.push_back(released(
            spread > 0 ? "1000 particles in a cell" : "1000 particles in a point", s, 0.2));
    }
    s = block_on_floor(usual);
    Material<double> stiff = clay_of(1e8, 0.3);
    fill(s, stiff, floor_of(s) + Place{-3 * cell, 4 * cell, -3 * cell},
         floor_of(s) + Place{3 * cell, 7 * cell, 3 * cell}, 2);
    all.push_back(released("clay 300 times as stiff on soft clay", s, 0.02));
}

void add_nonsense(std::vector<Case>& all)
{
    Material<double> m = elastic(1e5, 0.3, 1000);
    m.lambda = INFINITY;
    all.push_back(released("Poisson's ratio 0.5", block_on_floor(m), 0.02));
    all.back().nonsense = true;
    all.back().advice = "a scene's file is checked, a Setup in code is not: give finite constants";
    Case many = released("300 tools", block_on_floor(usual), 0.02);
    for (int i = 0; i < 300; ++i) add_ball_tool(many.setup, cell, ContactMode::separate, 0.3);
    many.at = [far = floor_of(many.setup) + Place{0, 0.12, 0}](double) {
        return std::vector(300, stands_at(far));
    };
    many.nonsense = true;
    many.advice = "at most 256 primitives: check before making a solver on the CPU";
    all.push_back(many);
    Setup s = block_on_floor(usual);
    s.particles[7].v.x = std::nan("");
    all.push_back(released("a particle that is no number", s, 0.02));
}

}  // namespace

std::vector<Case> stability_cases(bool quick)
{
    std::vector<Case> all;
    add_materials(all, quick), add_tools(all, quick);
    add_violence(all), add_crumbs(all), add_nonsense(all);
    return all;
}

void map_part(Verification& v)
{
    int counts[5] = {};
    const std::vector<Case> cases = stability_cases(v.quick());
    for (const Case& c : cases) {
        const Outcome o = outcome_of(v, c, v.quick() ? 8 : 60);
        ++counts[int(o.ending)];
        v.add(VerifyRow{"stability map",
                        c.name,
                        fmt::format("{}: {}", ending_name(o.ending), o.note),
                        {{"substeps", double(o.stats.substeps)},
                         {"dt_min_us", 1e6 * o.stats.dt_min},
                         {"energy_gain", o.energy_gain},
                         {"volume", o.volume},
                         {"seconds", o.seconds}}});
        v.say(fmt::format("{:<40} {}: {} ({:.1f} s)", c.name, ending_name(o.ending), o.note,
                          o.seconds));
        if (o.ending != Ending::failed) continue;
        Check check = at_most("map: " + c.name + ": failures", 1, 0, "", c.advice);
        check.note = o.note;
        v.add(check);
    }
    Check c = at_least("map: cases that ended stable, guarded or refused",
                       double(counts[0] + counts[1] + counts[3]),
                       double(cases.size()) - counts[int(Ending::failed)], "",
                       "the others ran out of time: run them without --quick");
    c.note = fmt::format("{} stable, {} guarded, {} slow, {} refused, {} failed", counts[0],
                         counts[1], counts[2], counts[3], counts[4]);
    v.add(c);
}

}  // namespace knead
