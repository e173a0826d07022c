// accuracy: a sphere pressed by its diameter into a block on a floor, and withdrawn. Elastic clay
// recovers; plastic clay keeps a hole of the sphere's size.
#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead {
namespace {

constexpr double dx = 0.01, speed = 0.5;            // [m]; maximum speed [m/s]
constexpr double frame = 1.0 / 180, mean_of = 0.1;  // [s]
constexpr double settle = 24 * frame, rest = 0.2;   // [s] before and after the press

struct Press {
    Setup setup;
    double radius, top, end;  // [m] [m] [s]
    Place axis;               // of the tool, on the surface

    // Lowest position of the tool's centre.
    Place deepest() const { return axis - Place{0, radius, 0}; }
    // Duration of the descent by the diameter, in whole frames: within a frame tools move linearly,
    // so a turn in mid-frame would not reach the full depth.
    double down() const { return frame * std::ceil(2 * radius / (speed * frame)); }
    double depth(double t) const
    {
        const double since = t - settle, way = 2 * radius / down() * since;
        if (since < -frame / 2) return -radius;
        return since < down() ? way : std::max(4 * radius - way, -dx);
    }
    std::vector<Joint<double>> at(double t) const
    {
        return {stands_at(axis + Place{0, radius - depth(t), 0})};
    }
};

Press press(double radius, const Material<double>& material, int passes = 2)
{
    const double cells = radius / dx;
    const int half = std::max(8, int(std::ceil(2 * cells)) + 6);
    const int high = std::max(10, int(std::ceil(5 * cells)));
    Press p{between_walls({2 * half + 4, high + int(4 * cells) + 4, 2 * half + 4}, dx,
                          ContactMode::separate, 0.3),
            radius,
            0,
            0,
            {}};
    Setup& s = p.setup;
    s.gravity = {0, -9.81, 0};
    const Place floor = floor_of(s), reach{half * dx, 0, half * dx};
    fill(s, material, floor - reach, floor + reach + Place{0, high * dx, 0}, 2);
    add_ball_tool(s, radius, ContactMode::separate, 0.3);
    s.passes = passes;
    p.top = floor.y + high * dx;
    p.axis = {floor.x, p.top, floor.z};
    p.end = settle + 2 * p.down() + rest;
    return p;
}

// Mean particle positions before the press and at the end.
struct Places {
    std::vector<Place> before, after;
    FrameStats stats;
};

Places pressed(Verification& v, const Press& p)
{
    const std::size_t n = p.setup.particles.size();
    Places places{std::vector<Place>(n, Place{}), std::vector<Place>(n, Place{}), {}};
    const auto solver = v.solver(p.setup);
    int before = 0, after = 0;
    const auto collect = [&](std::vector<Place>& sum, int& count) {
        const std::vector<Particle<double>> now = by_id(*solver);
        for (std::size_t i = 0; i < n; ++i) sum[i] = sum[i] + now[i].x;
        ++count;
    };
    places.stats = drive(
        *solver, frame, p.end, [&](double t) { return p.at(t); },
        [&](double t) {
            if (t <= settle && t > settle - mean_of) collect(places.before, before);
            if (t > p.end - mean_of) collect(places.after, after);
            return true;
        });
    for (std::size_t i = 0; i < n; ++i) {
        places.before[i] = (1.0 / before) * places.before[i];
        places.after[i] = (1.0 / after) * places.after[i];
    }
    return places;
}

double from_axis(const Press& p, Place x) { return std::hypot(x.x - p.axis.x, x.z - p.axis.z); }

std::string named(double radius) { return fmt::format("R = {:.3g} dx", radius / dx); }

struct Left {
    double dent = 0, aside = 0;  // [m]
    FrameStats stats;
};

Left left_in_elastic(Verification& v, const Press& p)
{
    const Places places = pressed(v, p);
    Left left{0, 0, places.stats};
    for (std::size_t i = 0; i < places.before.size(); ++i) {
        const Place way = places.after[i] - places.before[i];
        if (p.setup.particles[i].x.y > p.top - dx / 2) left.dent = std::fmax(left.dent, -way.y);
        left.aside = std::fmax(left.aside, std::hypot(way.x, way.z));
    }
    return left;
}

void elastic_block(Verification& v, double radius)
{
    const Left left = left_in_elastic(v, press(radius, elastic(1e5, 0.3, 1000)));
    const std::string advice =
        "press elastic clay less deep than the tool's radius, or expect a dent to stay";
    Check c = at_most("elastic block, " + named(radius) + ": dent left over D",
                      left.dent / (2 * radius), 0.10, "", advice);
    c.note =
        fmt::format("clipped {}, confined {}, repaired {}; {} substeps", left.stats[Count::clipped],
                    left.stats[Count::confined], left.stats[Count::repaired], left.stats.substeps);
    v.add(c);
    v.add(at_most("elastic block, " + named(radius) + ": farthest moved aside over D",
                  left.aside / (2 * radius), 0.10, "", advice));
}

// Control without projection: only the grid moves the clay, and hardly any dent may remain.
void without_projection(Verification& v, double radius)
{
    const Left left = left_in_elastic(v, press(radius, elastic(1e5, 0.3, 1000), 0));
    v.add(at_most("elastic block, " + named(radius) + ", no projection: dent left over D",
                  left.dent / (2 * radius), 0.02, "", "shorten the substep"));
}

// The hole, by particle distances from the volume swept by the tool: a ball below its lowest
// centre, a cylinder above. Width: from the nearest particle below the rim in each eighth of a
// turn; depth: from the innermost particle at the bottom. The hole has only a few particles, and
// none need lie on the axis or at the height of the tool's centre.
struct Hole {
    double width, depth;  // [m]
};

Hole hole_of(const Press& p, const std::vector<Place>& x, double surface)
{
    constexpr int parts = 8;
    double nearest[parts];
    std::fill(nearest, nearest + parts, p.radius);
    double bottom = -1e30;
    for (const Place& q : x) {
        const Place way = q - p.deepest();
        const double r = from_axis(p, q);
        const double off = (way.y < 0 ? length(way) : r) - p.radius;
        // Eighths centred on the axes and diagonals, where the lattice's particles lie.
        const double turn = std::atan2(way.z, way.x) / (2 * M_PI) + 1;
        double& best = nearest[int(turn * parts + 0.5) % parts];
        if (q.y < surface - 0.5 * p.radius) best = std::min(best, off);
        if (r < 0.8 * p.radius)
            bottom = std::max(bottom, way.y < 0 ? p.top - 2 * p.radius - off : q.y);
    }
    double sum = 0;
    for (const double off : nearest) sum += off / parts;
    return {2 * (p.radius + sum), surface - bottom};
}

void plastic_block(Verification& v, double radius)
{
    // Yield stress E / 100: elastic recovery is a few percent of the hole, below the bound. By
    // cavity expansion the wall recovers p / 2G of its radius, with p about 3 Y.
    constexpr double E = 4e5;
    const Press p = press(radius, plastic(E, 0.3, 1000, 0.01 * E));
    const Places places = pressed(v, p);
    double surface = 0;  // far from the hole, dx / 4 above the particles
    long count = 0;
    for (std::size_t i = 0; i < places.after.size(); ++i)
        if (p.setup.particles[i].x.y > p.top - dx / 2 &&
            from_axis(p, places.before[i]) > 2.5 * radius)
            surface += places.before[i].y, ++count;
    surface = surface / double(count) + dx / 4;
    const Hole hole = hole_of(p, places.after, surface);
    const double bound = std::max(dx / 4, 0.2 * radius);
    const std::string advice = "finer cells: a hole is as exact as a share of dx";
    v.add(near("clay block, " + named(radius) + ": width of the hole", hole.width / dx,
               2 * radius / dx, bound / dx, "dx", advice));
    v.add(near("clay block, " + named(radius) + ": depth of the hole", hole.depth / dx,
               2 * radius / dx, bound / dx, "dx", advice));
}

// Isolated particles fall on spheres too small for the lattice to resolve: contact must not add
// energy.
void crumbs(Verification& v)
{
    constexpr double fall = 2, radius = 0.6 * dx, apart = 2.3 * dx, gap = 2 * dx;  // [m/s] [m]
    Setup s = between_walls({32, 32, 32}, dx, ContactMode::separate, 0.3);
    const Place middle = floor_of(s) + Place{0, 12 * dx, 0};
    const int object = fill(s, plastic(1e5, 0.3, 1000, 1e3), middle, middle, 2);
    std::vector<Joint<double>> joints;
    for (int i = -2; i <= 2; ++i)
        for (int k = -2; k <= 2; ++k) {
            const Place tool = middle + Place{i * apart, 0.1 * k * dx, k * apart};
            add_ball_tool(s, radius, ContactMode::separate, 0.3);
            joints.push_back(stands_at(tool));
            Particle<double> q{};
            q.object = object;
            q.x = tool + Place{0.2 * radius, radius + gap, 0.1 * radius};
            q.v = {0, -fall, 0};
            s.particles.push_back(q);
        }
    const auto solver = v.solver(s);
    double fastest = 0;  // [m/s]
    const FrameStats stats = drive(
        *solver, frame, 0.06, [&](double) { return joints; },
        [&](double) {
            for (const Particle<double>& q : solver->particles())
                fastest = std::fmax(fastest, length(q.v));
            return true;
        });
    Check c = at_most("25 crumbs fall on as many small spheres at 2 m/s: the fastest after it",
                      fastest, 1.01 * fall, "m/s", "report it");
    c.note = fmt::format("{} times found inside in {} substeps", stats[Count::projected],
                         stats.substeps);
    v.add(c);
}

}  // namespace

void recovery_part(Verification& v)
{
    std::vector<double> cells{0.6, 1.28};
    if (!v.quick()) cells.insert(cells.end(), {2.56, 4});
    for (const double r : cells) elastic_block(v, r * dx);
    without_projection(v, 1.28 * dx);
    for (const double r : cells) plastic_block(v, r * dx);
    crumbs(v);
}

}  // namespace knead
