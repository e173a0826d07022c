// The cases of the stability map: inputs possible by user, file or API, and beyond.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/scene/presets.h"
#include "host/solver/substep.h"
#include "host/verify/cases.h"

namespace knead {
namespace {

constexpr double cell = 0.01;  // [m]

Material<double> clay_of(double young, double poisson)
{
    return plastic(young, poisson, 1600, young / 30);
}
const Material<double> usual = clay_of(3e5, 0.4);

// Stiff clay is pressed fast, to limit the number of substeps [m/s].
double press_speed(double young) { return young > 1e7 ? 10 : young > 1e5 ? 2 : 0.5; }

Case pressed(std::string name, const Material<double>& material, double young)
{
    return pressed_block(std::move(name), material, 2 * cell, press_speed(young), 2 * cell);
}

const std::vector<double> stiffnesses{1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};  // [Pa]

// Every preset, unchanged and with other stiffnesses.
void add_presets(std::vector<Case>& all, bool quick)
{
    std::size_t turn = 0;
    for (const MaterialSpec& usual_spec : material_specs()) {
        const std::string& name = usual_spec.name;
        // The slow ones are covered by part `steps`.
        if (!quick || (name != "snow" && name != "wet-sand"))
            all.push_back(pressed_block("preset " + name, preset(name), 2 * cell, 0.5, 2 * cell));
        const std::size_t chosen = (3 * turn++ + 2) % stiffnesses.size();
        for (std::size_t i = 0; i < stiffnesses.size(); ++i) {
            if (quick && i != chosen) continue;
            MaterialSpec spec = usual_spec;
            const bool fluid = spec.plasticity == Plasticity::fluid;
            (fluid ? spec.bulk : spec.young) = stiffnesses[i];
            all.push_back(pressed(
                fmt::format("{}, {} = {:.0e} Pa", name, fluid ? "bulk" : "E", stiffnesses[i]),
                made(spec), stiffnesses[i]));
        }
    }
}

void add_constants(std::vector<Case>& all, bool quick)
{
    for (const double E : stiffnesses)
        for (const double nu : {0.0, 0.3, 0.45, 0.49, 0.499}) {
            const bool corner = (E == 1e3 || E == 1e6 || E == 1e9) && nu != 0.3 && nu != 0.45;
            const bool costly = E == 1e9 && nu == 0.499;
            if (quick && (!corner || costly)) continue;
            all.push_back(pressed(fmt::format("E = {:.0e} Pa, nu = {}", E, nu), clay_of(E, nu), E));
        }
    for (const double share : {1e-3, 1e-2, 0.1, 1.0}) {
        if (quick && (share == 1e-2 || share == 0.1)) continue;
        all.push_back(pressed(fmt::format("yield stress of {} E", share),
                              plastic(3e5, 0.4, 1600, share * 3e5), 3e5));
    }
    for (const double density : {10.0, 100.0, 2e4}) {
        if (quick && density != 2e4) continue;
        Material<double> m = usual;
        m.density = density;
        all.push_back(
            pressed_block(fmt::format("density {} kg/m^3", density), m, 2 * cell, 0.5, 2 * cell));
    }
}

// Keeps 2 or 4 of the eight particles per cell: two opposite corners, or those of even parity.
Setup thinned(Setup s, int particles)
{
    std::vector<Particle<double>> kept;
    const double half = s.lattice.dx / 2;
    for (const Particle<double>& q : s.particles) {
        const auto odd = [&](double x) { return int(std::floor(x / half)) & 1; };
        const int x = odd(q.x.x), y = odd(q.x.y), z = odd(q.x.z);
        const bool stays = particles == 4 ? (x ^ y ^ z) == 0 : x == y && y == z;
        if (stays) kept.push_back(q);
    }
    s.particles = kept;
    Material<double>& m = s.materials.back();
    m.volume *= 8.0 / particles, m.mass *= 8.0 / particles;
    return s;
}

// Particles per cell, and cells along a domain of 16 cm.
void add_resolutions(std::vector<Case>& all, bool quick)
{
    for (const int per_axis : {1, 3, 4}) {
        if (quick && per_axis != 4) continue;
        all.push_back(pressed_block(
            per_axis == 1 ? "1 particle a cell"
                          : fmt::format("{} particles a cell", per_axis * per_axis * per_axis),
            usual, 2 * cell, 0.5, 2 * cell, per_axis));
    }
    for (const int particles : {2, 4}) {
        if (quick && particles == 4) continue;
        Case c = pressed_block(fmt::format("{} particles a cell", particles), usual, 2 * cell, 0.5,
                               2 * cell);
        c.setup = thinned(std::move(c.setup), particles);
        all.push_back(c);
    }
    for (const int cells : {16, 32, 64, 128, 192}) {
        if (quick && cells != 64) continue;
        const double dx = 0.16 / cells;
        Case c{fmt::format("{} cells across 16 cm", cells),
               between_walls({cells, cells, cells}, dx, ContactMode::separate, 0.3)};
        c.setup.gravity = {0, -9.81, 0};
        const Place floor = floor_of(c.setup), reach{3 * dx, 0, 3 * dx};
        fill(c.setup, usual, floor - reach, floor + reach + Place{0, 4 * dx, 0}, 2);
        add_ball_tool(c.setup, 2 * dx, ContactMode::separate, 0.3);
        const double down = 2 * dx / 0.5;
        c.at = [=](double t) {
            const double way = 0.5 * std::min(t, std::max(2 * down - t, 0.0));
            return std::vector{stands_at(floor + Place{0.1 * dx, 6.2 * dx - way, 0})};
        };
        c.action = 2 * down, c.end = 4 * down, c.frame = down / 4;
        all.push_back(c);
    }
}

void add_tools(std::vector<Case>& all, bool quick)
{
    for (const double speed : {0.01, 0.1, 1.0, 3.0, 10.0})
        if (!quick || speed > 1)
            all.push_back(pressed_block(fmt::format("tool at {} m/s", speed), usual, 2 * cell,
                                        speed, 3 * cell));
    for (const double radius : {0.1, 0.25, 0.5, 1.0, 2.0, 4.0})
        if (!quick || radius == 0.1 || radius == 4)
            all.push_back(pressed_block(fmt::format("tool of {} dx", radius), usual, radius * cell,
                                        0.5, std::min(4 * radius, 3.0) * cell));
    for (const std::string& name : preset_names())
        if (!quick || name == "clay" || name == "jelly")
            all.push_back(pressed_block(name + " pressed to one cell", preset(name), 40 * cell, 0.5,
                                        3 * cell));
}

// The block of pressed_block() with a ball tool of two cells radius at place(t).
Case moved_tool(std::string name, double action, std::function<Place(double)> place)
{
    Case c = pressed_block(std::move(name), usual, 2 * cell, 0.5, 0);
    c.at = [floor = floor_of(c.setup), place](double t) {
        return std::vector{stands_at(floor + place(t))};
    };
    c.action = action, c.end = action + 0.1, c.frame = 1.0 / 90;
    return c;
}

// Frame number at time t.
int frame_at(double t) { return int(t * 90 + 0.5); }

// Tools with tracking errors: they jump, vanish, reappear elsewhere and pass through each other.
void add_tracking(std::vector<Case>& all)
{
    all.push_back(moved_tool("a tool that stands still on the clay", 0.1, [](double) {
        return Place{0, 5.9 * cell, 0};
    }));
    all.push_back(moved_tool("a tool that jumps 12 dx at a time", 0.1, [](double t) {
        return Place{frame_at(std::min(t, 0.1)) % 2 ? 6 * cell : -6 * cell, 2 * cell, 0};
    }));
    const auto inside = [](double t) {  // leaves the clay at the end
        if (t > 0.1 - 1e-9) return Place{0, 12 * cell, 0};
        return Place{frame_at(t) % 2 ? 1.5 * cell : -1.5 * cell, 2 * cell, 0};
    };
    all.push_back(moved_tool("a tool that jumps within the clay", 0.1, inside));
    Case appears = moved_tool("a tool that appears within the clay", 0.1, inside);
    appears.active = [](double t) { return std::vector<char>{char(frame_at(t) % 3 == 2)}; };
    all.push_back(appears);
    Case lost = pressed_block("a tool lost and found in the clay", usual, 2 * cell, 0.5, 3 * cell);
    lost.active = [](double t) { return std::vector<char>{char(frame_at(t) % 3 != 1)}; };
    lost.end = lost.action + 0.1;
    all.push_back(lost);
    Case crossing = pressed_block("two tools that cross in the clay", usual, 2 * cell, 1, 0);
    add_ball_tool(crossing.setup, 2 * cell, ContactMode::sticky, 0.3);
    crossing.at = [floor = floor_of(crossing.setup)](double t) {
        const double x = 6 * cell - 1 * std::min(t, 0.12);
        return std::vector{stands_at(floor + Place{x, 2 * cell, 0}),
                           stands_at(floor + Place{-x, 2 * cell, 0})};
    };
    crossing.action = 0.12, crossing.end = 0.22;
    all.push_back(crossing);
}

// A blade 0.2 dx thick, 12 cells wide and 8 high, on its own joint.
void add_blade_tool(Setup& s)
{
    const auto joint = int(s.tools.size()), first = int(s.rig.spheres.size());
    for (const Place corner : {Place{-6, 0, 0}, Place{6, 0, 0}, Place{-6, 8, 0}, Place{6, 8, 0}}) {
        Binding<float> b{};
        for (int& j : b.joint) j = joint;
        b.weight[0] = 1, b.radius = float(0.1 * cell);
        b.offset[0] = cast<float>(cell * corner);
        s.rig.spheres.push_back(b);
    }
    s.rig.primitives.push_back({3, {first, first + 1, first + 2}, joint});
    s.rig.primitives.push_back({3, {first + 1, first + 3, first + 2}, joint});
    s.tools.push_back({ContactMode::separate, 0.3, true, true});
}

// Strokes of a blade down to the floor, each rotated and displaced relative to the previous one.
Case shredded(const std::string& name, const Material<double>& material, int strokes)
{
    Case c{name + " cut to shreds", block_on_floor(material)};
    add_blade_tool(c.setup);
    constexpr double stroke = 0.1;  // [s]
    const double end = strokes * stroke;
    c.at = [floor = floor_of(c.setup), end](double t) {
        const double at = std::min(t, end - 1e-9) / stroke, share = at - std::floor(at);
        const int i = int(at);
        // Descends for 0.4 of a stroke, rises for 0.4, stays above the clay for the rest.
        const double up = std::min(std::fabs(share - 0.4) / 0.4, 1.0) * 5.5 - 0.1;
        const Place aside{((i * 7) % 5 - 2) * cell, up * cell, ((i * 3) % 5 - 2) * cell};
        return std::vector{Joint<double>{turn_about(Place{0, 1, 0}, 1.1 * i), floor + aside}};
    };
    c.action = end, c.end = end + 0.1, c.frame = stroke / 10, c.limit = 6 * strokes;
    return c;
}

// Two balls press the clay repeatedly from above and from the side.
Case long_kneading(double substeps)
{
    Case c = pressed_block(fmt::format("kneaded for {:.0e} substeps", substeps), usual, 2 * cell,
                           0.5, 0);
    add_ball_tool(c.setup, 2 * cell, ContactMode::separate, 0.3);
    const double dt = choose_dt(step_limits(c.setup), {}, 1, 1).dt, end = substeps * dt;
    c.at = [floor = floor_of(c.setup), end](double t) {
        const double w = 2 * std::numbers::pi * std::min(t, end), out = t >= end ? 8 * cell : 0;
        const Place above{1.5 * cell * std::sin(0.37 * w), (5.5 + 2 * std::cos(2 * w)) * cell + out,
                          1.5 * cell * std::cos(0.23 * w)};
        const Place beside{(5 + 2 * std::cos(1.3 * w)) * cell + out, 1.5 * cell,
                           1.5 * cell * std::sin(0.31 * w)};
        return std::vector{stands_at(floor + above), stands_at(floor + beside)};
    };
    c.action = end, c.end = end + 0.1, c.limit = std::max(20.0, substeps * 5e-4);
    return c;
}

void add_labour(std::vector<Case>& all, bool quick, bool gpu)
{
    all.push_back(shredded("clay", usual, quick ? 4 : 20));
    if (!quick) all.push_back(shredded("jelly", elastic(1e5, 0.45, 1050), 20));
    all.push_back(long_kneading(quick ? 1e4 : gpu ? 1e6 : 1e5));
}

// Clay released from its initial state, without tools.
Case released(std::string name, Setup s, double end = 0.15)
{
    Case c{std::move(name), std::move(s)};
    c.end = end, c.frame = 1.0 / 360;
    return c;
}

// A ball of 3 cells radius in mid-air.
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

// Two stacked blocks, one 1000 times as dense.
void add_weights(std::vector<Case>& all)
{
    for (const bool heavy_above : {true, false}) {
        Setup s = block_on_floor(elastic(1e5, 0.3, heavy_above ? 10 : 1e4));
        const Place floor = floor_of(s);
        fill(s, elastic(1e5, 0.3, heavy_above ? 1e4 : 10),
             floor + Place{-2 * cell, 4 * cell, -2 * cell},
             floor + Place{2 * cell, 7 * cell, 2 * cell}, 2);
        all.push_back(released(heavy_above ? "a block 1000 times as dense on a light one"
                                           : "a light block on one 1000 times as dense",
                               s, 0.04));
    }
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

std::vector<Case> stability_cases(bool quick, bool gpu)
{
    std::vector<Case> all;
    add_presets(all, quick), add_constants(all, quick), add_resolutions(all, quick);
    add_tools(all, quick), add_tracking(all), add_labour(all, quick, gpu);
    add_violence(all), add_crumbs(all), add_weights(all), add_nonsense(all);
    return all;
}

}  // namespace knead
