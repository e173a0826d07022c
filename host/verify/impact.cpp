// accuracy: impact of a copper rod on a rigid wall, against finite elements; a spinning ball.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/verify/cases.h"

namespace knead {
namespace {

// The usual Taylor bar: 32.4 mm long, radius 3.2 mm, 227 m/s, without friction, E 117 GPa, nu 0.35,
// 8930 kg/m^3, yield stress 400 MPa, hardening 100 MPa, after 80 us. Lagrangian finite elements
// give a length of 21.3 to 21.7 mm and a foot of 7.0 to 7.2 mm radius [Kamoulakos 1990; Zhu &
// Cescotto 1995; Camacho & Ortiz 1997]. Against a wall, and against a second rod at the opposite
// velocity: the results must agree.
struct Rod {
    double length, foot;  // [m]
    FrameStats stats;
};

Rod taylor_bar(Verification& v, int cells, bool wall)
{
    constexpr double length = 0.0324, radius = 0.0032, end = 80e-6, speed = 227;
    const double dx = radius / cells;
    const int wide = 6 * cells, high = int(std::ceil(length / dx)) + 4;
    Setup s = between_walls({wide, wall ? high : 2 * high, wide}, dx, ContactMode::slip, 0);
    Material<double> copper = plastic(117e9, 0.35, 8930, 400e6);
    copper.hardening = 100e6;
    const Place meet = floor_of(s) + Place{0, wall ? 0 : high * dx, 0};
    fill(s, copper, s.walls.min, s.walls.max, 2, [&](Place x) {
        return std::hypot(x.x - meet.x, x.z - meet.z) < radius && std::fabs(x.y - meet.y) < length;
    });
    const auto extent = [&](const std::vector<Particle<double>>& all) {
        double top = 0, side = 0;
        for (const Particle<double>& q : all) {
            top = std::max(top, q.x.y - meet.y);
            side = std::max(side, std::hypot(q.x.x - meet.x, q.x.z - meet.z));
        }
        return std::pair{top + dx / 4, side + dx / 4};  // half a particle's edge
    };
    const double before = extent(s.particles).first;
    for (Particle<double>& q : s.particles) q.v = {0, q.x.y > meet.y ? -speed : speed, 0};
    const auto solver = v.solver(s);
    const FrameStats stats = drive(*solver, end / 40, end, [](double) { return true; });
    const auto [top, foot] = extent(solver->particles());
    return {top * length / before, foot, stats};
}

void taylor_bars(Verification& v)
{
    const int cells = v.quick() ? 4 : 6;  // cells per radius
    const std::string advice = "where clay is squashed flat, expect its rim to spread too little";
    for (const bool wall : {true, false}) {
        const Rod rod = taylor_bar(v, cells, wall);
        const std::string name = wall ? "Taylor bar: " : "Taylor bars, head-on: ";
        Check c = near(name + "length after 80 us", 1e3 * rod.length, 21.5, 0.65, "mm", advice);
        c.note = fmt::format("{} cells across the radius; clipped {}, confined {}, repaired {}",
                             cells, rod.stats[Count::clipped], rod.stats[Count::confined],
                             rod.stats[Count::repaired]);
        v.add(c);
        v.add(near(name + "radius of the foot", 1e3 * rod.foot, 7.1, 0.36, "mm", advice));
    }
}

// A freely rotating elastic ball: angle = spin times time, energy is conserved.
void spinning(Verification& v)
{
    constexpr double dx = 0.01, turns = 3;
    const Vec3<double> axis{0.48, 0.6, 0.64};
    constexpr double rate = 40;  // [1/s]
    Setup s = between_walls({20, 20, 20}, dx, ContactMode::separate, 0);
    const Place middle = s.walls.min + Place{10 * dx, 10 * dx, 10 * dx};
    fill(s, elastic(1e6, 0.3, 1000), s.walls.min, s.walls.max, 2,
         [&](Place x) { return length(x - middle) < 5 * dx; });
    const Vec3<double> w = rate * axis;
    for (Particle<double>& q : s.particles) {
        q.v = cross(w, q.x - middle);
        q.C = {{0, w.z, -w.y}, {-w.z, 0, w.x}, {w.y, -w.x, 0}};
    }
    const double before = energy_of(s.particles, s);
    const auto solver = v.solver(s);
    const double end = turns * 2 * std::numbers::pi / rate;
    drive(*solver, end / 60, end, [](double) { return true; });
    const std::vector<Particle<double>> now = by_id(*solver);
    // After whole turns every particle should be at its initial position: mean remaining rotation.
    double turned = 0, arm = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
        const Place r = s.particles[i].x - middle, way = now[i].x - s.particles[i].x;
        turned += dot(cross(r, way), axis);
        arm += dot(r, r) - dot(r, axis) * dot(r, axis);
    }
    v.add(near("spinning ball: angle after 3 turns", 360 * turns + turned / arm * 180 / M_PI,
               360 * turns, 5, "degrees", "turning clay lags: refine"));
    v.add(near("spinning ball: energy after 3 turns", 100 * energy_of(now, s) / before, 100, 1, "%",
               "turning clay slows down: refine"));
}

}  // namespace

void impact_part(Verification& v) { spinning(v), taylor_bars(v); }

}  // namespace knead
