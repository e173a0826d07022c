// accuracy: elastic balls and cylinders that slide on a floor until they roll, roll down a slope,
// and come to rest; against rigid bodies.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead {
namespace {

constexpr double g = 9.81, R = 0.1, friction = 0.4;  // [m/s^2] [m]

// A rolling body: a ball, or a cylinder along z; its moment of inertia is `inertia` m R^2.
struct Roller {
    const char* name;
    bool ball;
    double inertia;
    // Share of the driving force that accelerates the centre.
    double rolls() const { return 1 / (1 + inertia); }
};
constexpr Roller ball{"ball", true, 0.4}, cylinder{"cylinder", false, 0.5};

// Slides from speed v0 until it rolls at v0 / (1 + inertia).
struct Travel {
    double way, speed;  // [m] [m/s]
};
Travel slide_and_roll(const Roller& r, double v0, double t)
{
    const double until = (1 - r.rolls()) * v0 / (friction * g), slides = std::fmin(t, until);
    const double speed = v0 - friction * g * slides;
    return {v0 * slides - friction * g * slides * slides / 2 + speed * (t - slides), speed};
}

// From rest down a slope: rolls up to tan(angle) = f (1 + inertia) / inertia, slides on steeper
// ones.
Travel down(const Roller& r, double angle, double t)
{
    const bool holds = std::tan(angle) <= friction * (1 + r.inertia) / r.inertia;
    const double pull =
        holds ? r.rolls() * std::sin(angle) : std::sin(angle) - friction * std::cos(angle);
    return {g * pull * t * t / 2, g * pull * t};
}

// The body on the floor, `cells` per diameter, at the start of a track of length `way` [m], its
// centre offset by `off` [cells] from a node.
Setup standing(const Roller& r, int cells, double way, double off = 0)
{
    const double dx = 2 * R / cells;
    const int wide = r.ball ? cells + 8 : 8, along = int(std::ceil((way + 2 * R) / dx)) + 10;
    Setup s = between_walls({along, cells + 8, wide}, dx, ContactMode::separate, friction);
    s.gravity = {0, -g, 0};
    const Place aside{off * dx, 0, 0};
    const Place centre = s.walls.min + aside + Place{R + 4 * dx, R, 0.5 * wide * dx};
    fill(s, elastic(1e6, 0.3, 1000), s.walls.min + aside, s.walls.max, 2, [&](Place x) {
        const Place from = x - centre;
        return r.ball ? length(from) < R
                      : std::hypot(from.x, from.y) < R && std::fabs(from.z) < 2 * dx;
    });
    return s;
}

// Rigid motion: position and velocity of the centre, angular velocity about z [1/s].
struct Body {
    Place x{};
    Vec3<double> v{};
    double turning = 0;
};
Body body_of(const std::vector<Particle<double>>& all)
{
    Body b;
    for (const Particle<double>& q : all) b.x = b.x + q.x, b.v = b.v + q.v;
    b.x = (1.0 / double(all.size())) * b.x, b.v = (1.0 / double(all.size())) * b.v;
    double L = 0, I = 0;
    for (const Particle<double>& q : all) {
        const Place off = q.x - b.x;
        L += off.x * (q.v.y - b.v.y) - off.y * (q.v.x - b.v.x);
        I += off.x * off.x + off.y * off.y;
    }
    b.turning = L / I;
    return b;
}

const char* const coarse = "a body of few cells that rolls is slowed: refine";

void on_the_flat(Verification& v, const Roller& r, int cells)
{
    constexpr double v0 = 1, end = 0.8;
    const Travel right = slide_and_roll(r, v0, end);
    Setup s = standing(r, cells, right.way);
    const double from = body_of(s.particles).x.x;
    for (Particle<double>& q : s.particles) q.v.x = v0;
    const auto solver = v.solver(s);
    const FrameStats stats = drive(*solver, 0.02, end, [](double) { return true; });
    const Body b = body_of(solver->particles());
    const std::string name = fmt::format("{} of {} cells set off at 1 m/s: ", r.name, cells);
    const double bound = cells < 12 ? 12 : cells < 16 ? 9 : 7;
    Check c = near(name + "way in 0.8 s, over a rigid one's", 100 * (b.x.x - from) / right.way, 100,
                   bound, "%", coarse);
    c.note = fmt::format(
        "{:.3f} m of {:.3f}, {:.3f} m/s of {:.3f}, middle {:+.2f} dx off R; "
        "confined {}",
        b.x.x - from, right.way, b.v.x, right.speed, (b.x.y - s.walls.min.y - R) / s.lattice.dx,
        stats[Count::confined]);
    v.add(c);
    v.add(near(name + "speed of the rim, over that of the middle", -100 * b.turning * R / b.v.x,
               100, 3, "%", coarse));
}

// Mean over four offsets of the body between nodes: the orientation of its flattest side determines
// when it starts.
void down_a_slope(Verification& v, const Roller& r, int cells, int degrees)
{
    const double end = degrees > 20 ? 0.3 : 0.5, angle = degrees * std::numbers::pi / 180;
    const Travel right = down(r, angle, end);
    double sum = 0, least = 1e9, most = 0;
    for (const double off : {0.0, 0.25, 0.5, 0.75}) {
        Setup s = standing(r, cells, right.way, off);
        s.gravity = {g * std::sin(angle), -g * std::cos(angle), 0};
        const double from = body_of(s.particles).x.x;
        const auto solver = v.solver(s);
        drive(*solver, 0.02, end, [](double) { return true; });
        const double way = body_of(solver->particles()).x.x - from;
        sum += way, least = std::fmin(least, way), most = std::fmax(most, way);
    }
    Check c = near(fmt::format("{} of {} cells on {} degrees: way in {} s, over a rigid one's",
                               r.name, cells, degrees, end),
                   100 * sum / 4 / right.way, 100, 10, "%", coarse);
    c.note = fmt::format("{:.4f} to {:.4f} m of {:.4f}", least, most, right.way);
    v.add(c);
}

// A block dropped from a height of `drop` cells: its lowest particles come to rest half their
// spacing above the floor.
void at_rest(Verification& v)
{
    constexpr double dx = 0.0125, drop = 1.7, h = 0.5;  // [m] [cells]
    for (const double place : {0.0, 0.25, 0.5, 0.75}) {
        Setup s = between_walls({16, 14, 16}, dx, ContactMode::separate, friction);
        s.gravity = {0, -g, 0};
        const Place corner = s.walls.min + Place{4 * dx, 0, 4 * dx};
        fill(s, elastic(1e6, 0.3, 1000), corner, corner + Place{8 * dx, 8 * dx, 8 * dx}, 2);
        for (Particle<double>& q : s.particles)
            q.x = q.x + Place{place * dx, (drop + place) * dx, 0};
        const auto solver = v.solver(s);
        drive(*solver, 0.02, 1, [](double) { return true; });
        double sum = 0, count = 0;
        const std::vector<Particle<double>> all = by_id(*solver);
        for (std::size_t i = 0; i < all.size(); ++i)
            if (s.particles[i].x.y < s.walls.min.y + (drop + place + 0.75 * h) * dx)
                sum += (all[i].x.y - s.walls.min.y) / dx, count += 1;
        v.add(
            near(fmt::format("block dropped from {} cells: its lowest layer at rest", drop + place),
                 sum / count, h / 2, 0.1, "dx", "clay stands a little above its floor"));
    }
}

}  // namespace

void rolling_part(Verification& v)
{
    for (const int cells : v.quick() ? std::vector{8} : std::vector{8, 12, 16, 24}) {
        on_the_flat(v, ball, cells);
        for (const int degrees : {10, 30, 60}) down_a_slope(v, ball, cells, degrees);
    }
    // A cylinder consists of rows of particles and rests on a facet 2 sqrt(R h) wide.
    for (const int cells : v.quick() ? std::vector{24} : std::vector{24, 48}) {
        on_the_flat(v, cylinder, cells);
        for (const int degrees : {10, 20}) down_a_slope(v, cylinder, cells, degrees);
    }
    at_rest(v);
}

}  // namespace knead
