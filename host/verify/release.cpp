// convergence: speed of a ball after release by two tools, one after the other.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/verify/squeeze.h"

namespace knead {
namespace {

constexpr double radius = 0.25, tool_radius = 0.1;  // [m]
constexpr double deep = 0.06, gap = 0.01;           // [m]: depth of each tool; initial distance
constexpr double speed = 0.5;                       // of each tool, in and out [m/s]
constexpr double hold = 0.12, lag = 0.2;  // [s]: both tools rest; delay of the second release
constexpr double flight = 0.15;           // [s]: after the start of the second release
constexpr int phases = 6;                 // offsets of ball and tools relative to the nodes

// Speed of the ball along the tools' axis after both releases [m/s].
double speed_of(const Verification& v, int cells, double phase)
{
    const double dx = 1.0 / cells;
    Setup s = between_walls({cells, cells, cells}, dx, ContactMode::separate, 0.3);
    const Place middle = s.walls.min + Place{0.5, 0.5, 0.5} + (phase * dx) * Place{1, 0.37, 0.61};
    // The same particles for every phase: others would shift the faces of the ball.
    const Place reach{radius, radius, radius};
    fill(s, plastic(1e6, 0.3, 1000, 1e5), middle - reach, middle + reach, 2,
         [&](Place x) { return length(x - middle) < radius; });
    for (int i = 0; i < 2; ++i) add_ball_tool(s, tool_radius, ContactMode::separate, 0.4);
    const double in = (deep + gap) / speed, out = in + hold;
    const auto at = [=](double t) {
        const auto away = [=](double leaves) {
            return radius + tool_radius + gap - speed * std::min(t, in) +
                   speed * std::max(0.0, t - leaves);
        };
        return std::vector{stands_at(middle - Place{away(out + lag), 0, 0}),
                           stands_at(middle + Place{away(out), 0, 0})};
    };
    const auto solver = v.solver(s);
    drive(*solver, 0.01, out + lag + flight, at, [](double) { return true; });
    double sum = 0;
    const std::vector<Particle<double>> all = by_id(*solver);
    for (const Particle<double>& q : all) sum += q.v.x;
    return sum / double(all.size());
}

struct Speeds {
    double mean = 0, spread = 0;  // over the phases; spread: standard deviation [m/s]
};
Speeds speeds(const Verification& v, int cells)
{
    double sum = 0, squares = 0;
    for (int i = 0; i < phases; ++i) {
        const double u = speed_of(v, cells, double(i) / phases);
        sum += u, squares += u * u;
    }
    const double mean = sum / phases;
    return {mean, std::sqrt(std::max(0.0, squares / phases - mean * mean) * phases / (phases - 1))};
}

}  // namespace

void release_checks(Verification& v)
{
    const int few = 16, many = v.quick() ? 32 : 48;
    const Speeds coarse = speeds(v, few), fine = speeds(v, many);
    const std::string advice =
        "where let-go clay comes to rest is known no better than this: repeat the run with the "
        "scene moved by parts of a cell, and take the mean";
    Check falls = at_most(fmt::format("release, {} against {} cells per m: spread of the speed "
                                      "over places between the nodes",
                                      many, few),
                          fine.spread / coarse.spread, 0.7, "", advice);
    falls.note = fmt::format("{:.0f} +- {:.0f} and {:.0f} +- {:.0f} mm/s", 1e3 * fine.mean,
                             1e3 * fine.spread, 1e3 * coarse.mean, 1e3 * coarse.spread);
    v.add(falls);
    v.add(at_most(fmt::format("release, {} cells per m: spread of the speed, of its mean", many),
                  100 * fine.spread / std::fabs(fine.mean), 10, "%", advice));
}

}  // namespace knead
