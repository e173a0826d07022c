// accuracy: head-on collision of two elastic spheres, against Hertz.
#include <fmt/format.h>

#include <cmath>

#include "host/solver/audit.h"
#include "host/verify/cases.h"

namespace knead {
namespace {

constexpr double young = 1e6, poisson = 0.3, density = 1000, dx = 0.01;

// Two equal balls of radius R approach at relative speed v. By Hertz's law the force is F = 4/3 E*
// sqrt(R/2) d^(3/2), E* = E / (2 (1 - nu^2)), with the reduced mass, and they separate after 2.87
// (m^2 / (R E*^2 v))^(1/5) [Johnson 1985, 11.4]. Returns the time between 5 % and 95 % of the
// momentum exchange [s], which does not depend on detecting first contact.
double hertz_time(double R, double v)
{
    const double mass = 2 * M_PI / 3 * R * R * R * density;  // reduced
    const double stiff = 2.0 / 3 * young / (1 - poisson * poisson) * std::sqrt(R / 2);
    double d = 0, u = v, t = 0, from = 0;
    const double step = 1e-5 * R / v;
    while (u > -0.9 * v) {
        u -= step * stiff / mass * d * std::sqrt(d), d += step * u, t += step;
        if (u > 0.9 * v) from = t;
    }
    return t - from;
}

struct Met {
    double time;         // contact time as above, over Hertz's
    double restitution;  // relative speed after the collision over that before
    double kept;         // fraction of total energy
    double momentum;     // total momentum at the end, over that of one ball
    double gap;          // distance of the surfaces when 1 % of the momentum is exchanged [dx]
};

// Two balls of radius R, surfaces `apart` [m], relative speed `speed` [m/s].
Setup two_balls(int cells, double apart, double speed)
{
    const double R = cells * dx;
    Setup s =
        between_walls({6 * cells + 8, 2 * cells + 8, 2 * cells + 8}, dx, ContactMode::separate, 0);
    const Place middle = 0.5 * (s.walls.min + s.walls.max);
    for (const double side : {-1.0, 1.0}) {
        const Place centre = middle + Place{side * (R + apart / 2), 0, 0};
        fill(s, elastic(young, poisson, density), s.walls.min, s.walls.max, 2,
             [&](Place x) { return length(x - centre) < R; });
    }
    for (Particle<double>& q : s.particles) q.v = {q.object == 0 ? speed / 2 : -speed / 2, 0, 0};
    return s;
}

Met met(Verification& v, int cells)
{
    const double R = cells * dx, c = std::sqrt(young / density), speed = 0.05 * c, apart = 2 * dx;
    const Setup s = two_balls(cells, apart, speed);
    const auto of_one = [&](const std::vector<Particle<double>>& all, auto&& what) {
        double sum[2] = {}, n[2] = {};
        for (const Particle<double>& q : all) sum[q.object] += what(q), n[q.object] += 1;
        return sum[0] / n[0] - sum[1] / n[1];
    };
    const auto closing = [](const Particle<double>& q) { return q.v.x; };
    const auto place = [](const Particle<double>& q) { return q.x.x; };
    const double hertz = hertz_time(R, speed), begun = of_one(s.particles, closing),
                 energy = energy_of(s.particles, s), centres = of_one(s.particles, place),
                 step = hertz / 60;
    const auto solver = v.solver(s);
    double from = 0, to = 0, before = begun, at = centres;
    Met m{};
    drive(*solver, step, apart / speed + 3 * hertz, [&](double t) {
        const std::vector<Particle<double>> now = solver->particles();
        const double u = of_one(now, closing);
        const auto crossed = [&](double level) {
            return t - step * (u - level * begun) / (u - before);
        };
        if (before > 0.9 * begun && u <= 0.9 * begun) from = crossed(0.9);
        if (before > -0.9 * begun && u <= -0.9 * begun) to = crossed(-0.9);
        if (u > 0.99 * begun) at = of_one(now, place);
        before = u;
        return true;
    });
    const std::vector<Particle<double>> now = solver->particles();
    const Audit a = audit(now, s.materials, dx);
    m.time = (to - from) / hertz, m.restitution = -before / begun;
    m.kept = energy_of(now, s) / energy;
    m.momentum = length(a.momentum) / (a.mass * speed / 2);
    m.gap = (-at - 2 * R) / dx;
    return m;
}

}  // namespace

// Hertz's law holds for small contacts; here the contact radius grows to 0.3 R. Waves take less
// than 1 % of the energy [Johnson 1985, 11.4], so any larger loss is numerical. Contact acts
// through the lattice, at most one cell before the surfaces touch.
void spheres_part(Verification& v)
{
    for (const int cells : v.quick() ? std::vector{8} : std::vector{8, 12}) {
        const Met m = met(v, cells);
        const std::string name = fmt::format("spheres of R = {} dx: ", cells);
        const std::string rough = "small parts bounce too late and too softly: refine";
        v.add(near(name + "time of contact, over Hertz's", m.time, 1, 0.1, "", rough));
        v.add(at_least(name + "coefficient of restitution", m.restitution, 0.95, "", rough));
        v.add(near(name + "energy kept", 100 * m.kept, 100, 5, "%", rough));
        v.add(at_most(name + "momentum of both, of one's", m.momentum, 1e-6, ""));
        v.add(at_most(name + "gap when a 100th of momentum is gone", m.gap, 1, "dx",
                      "clay meets clay too early: leave a cell between parts"));
    }
}

}  // namespace knead
