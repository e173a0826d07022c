// accuracy: bodies on a floor: a sliding block, a block on a slope, a liquid column.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "host/solver/reference.h"
#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead {
namespace {

constexpr double g = 9.81, dx = 0.01;  // [m/s^2] [m]

Vec3<double> mean_velocity(const std::vector<Particle<double>>& all)
{
    Vec3<double> sum{};
    for (const Particle<double>& q : all) sum = sum + q.v;
    return (1.0 / double(all.size())) * sum;
}

Place middle(const std::vector<Particle<double>>& all)
{
    Place sum{};
    for (const Particle<double>& q : all) sum = sum + q.x;
    return (1.0 / double(all.size())) * sum;
}

// A block of 8 x 4 x 8 cells after 0.15 s on the floor.
Setup settled_block(Verification& v, double friction)
{
    Setup s = between_walls({40, 8, 14}, dx, ContactMode::separate, friction);
    s.gravity = {0, -g, 0};
    const Place corner = s.walls.min + Place{4 * dx, 0, 3 * dx};
    fill(s, elastic(3e5, 0.3, 1000), corner, corner + Place{8 * dx, 4 * dx, 8 * dx}, 2);
    const auto solver = v.solver(s);
    drive(*solver, 0.01, 0.15, [](double) { return true; });
    s.particles = by_id(*solver);
    return s;
}

// Deceleration of a block pushed along the floor: the slope of its mean velocity over time.
void sliding(Verification& v)
{
    constexpr double friction = 0.3, expected = friction * g;
    Setup s = settled_block(v, friction);
    for (Particle<double>& q : s.particles) q.v.x += 1;
    const auto solver = v.solver(s);
    double n = 0, t1 = 0, v1 = 0, tt = 0, tv = 0;
    drive(*solver, 0.005, 0.2, [&](double t) {
        const double speed = mean_velocity(solver->particles()).x;
        if (t > 0.05) n += 1, t1 += t, v1 += speed, tt += t * t, tv += t * speed;
        return true;
    });
    const double slope = (n * tv - t1 * v1) / (n * tt - t1 * t1);
    v.add(near("sliding block: deceleration", -slope, expected, 0.03 * expected, "m/s^2",
               "scale the friction of walls by the ratio of the two numbers"));
}

// On a slope just below the friction angle, tilted at once: it springs down under the sudden load.
void sudden_slope(Verification& v)
{
    constexpr double angle = 20 * std::numbers::pi / 180;
    Setup s = settled_block(v, std::tan(angle) / 0.91);
    s.gravity = {g * std::sin(angle), -g * std::cos(angle), 0};
    const Place before = middle(s.particles);
    const auto solver = v.solver(s);
    drive(*solver, 0.05, 0.8, [](double) { return true; });
    const double way = length(middle(solver->particles()) - before);
    v.add(at_most("block on a slope of 20 degrees, tan = 0.91 f: way in 0.8 s", 1e3 * way, 0.2,
                  "mm", "use sticky walls where clay must not creep"));
}

// The same, tilted slowly.
void slow_slope(Verification& v)
{
    constexpr double steepest = 20 * std::numbers::pi / 180, tilted = 0.4;
    Setup s = settled_block(v, std::tan(steepest) / 0.91);
    const Place before = middle(s.particles);
    auto solver = v.solver(s);
    for (int frame = 1; frame <= 120; ++frame) {
        const double angle = std::fmin(frame * 0.01 / tilted, 1) * steepest;
        s.gravity = {g * std::sin(angle), -g * std::cos(angle), 0};
        if (!solver->editable())
            s.particles = solver->particles(), solver = v.solver(s);
        else if (frame * 0.01 < tilted + 0.015)
            solver->editable()->set_gravity(s.gravity);
        drive(*solver, 0.01, 0.01, [](double) { return true; });
    }
    const double way = length(middle(solver->particles()) - before);
    v.add(at_most("block tilted to 20 degrees, tan = 0.91 f: way in 1.2 s", 1e3 * way, 0.05, "mm",
                  "use sticky walls where clay must not creep"));
}

// Mean pressure in tenths of the height, bottom to top, over the second half of a second.
void liquid(Verification& v)
{
    constexpr int cells = 32, tenths = 10;
    Setup s = between_walls({4, cells + 6, 4}, dx, ContactMode::slip, 0);
    s.gravity = {0, -g, 0};
    Material<double> m{};
    m.plasticity = Plasticity::fluid;
    m.density = 1400, m.bulk = 1400.0 * 25 * 25, m.exponent = 7, m.viscosity = 30;
    const Place top{s.walls.max.x, s.walls.min.y + cells * dx, s.walls.max.z};
    fill(s, m, s.walls.min, top, 2);
    const auto solver = v.solver(s);
    double p[tenths] = {}, depth[tenths] = {}, count[tenths] = {};
    const double height = cells * dx, end = v.quick() ? 0.6 : 1.0;
    drive(*solver, 0.005, end, [&](double t) {
        if (t <= end / 2) return true;
        for (const Particle<double>& q : solver->particles()) {
            const double up = q.x.y - s.walls.min.y;
            const int i = std::min(int(tenths * up / height), tenths - 1);
            const double log_J = 0.5 * std::log1p(determinant_excess(q.e));
            p[i] += m.bulk / m.exponent * std::expm1(-m.exponent * log_J);
            depth[i] += up, count[i] += 1;
        }
        return true;
    });
    const double whole = m.density * g * height;
    double worst = 0;
    for (int i = 1; i + 1 < tenths; ++i) {
        const double expected = m.density * g * (height - depth[i] / count[i]);
        const double off = (p[i] / count[i] - expected) / whole;
        if (std::fabs(off) > std::fabs(worst) || std::isnan(off)) worst = off;
    }
    v.add(near("liquid at rest, 32 cells deep: worst pressure of the inner tenths, over rho g h",
               100 * worst, 0, 3, "%", "pressures near floors are a cell's weight off"));
}

}  // namespace

void floor_part(Verification& v) { sliding(v), sudden_slope(v), slow_slope(v), liquid(v); }

}  // namespace knead
