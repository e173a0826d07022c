// workprecision: an elastic cantilever, clamped by a block so stiff and heavy that it hardly moves,
// swings under its own weight. The mean over a swing is the static deflection: for length L and
// height h, by bending and shear [Timoshenko 1921; Cowper 1966, 5/6 for nu = 0],
//     w(x) = rho g / (2 E h^2) x^2 (6 L^2 - 4 L x + x^2) + (6 / 5) rho g / G (L x - x^2 / 2)
#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/verify/front.h"

namespace knead {
namespace {

constexpr double young = 1e6, density = 1000, g = 0.2;  // [Pa] [kg/m^3] [m/s^2]
constexpr double beam = 1, high = 0.25;                 // [m]

double bent(double x)
{
    const double bending =
        density * g / (2 * young * high * high) * x * x * (6 * beam * beam - 4 * beam * x + x * x);
    return bending + 1.2 * density * g / (young / 2) * (beam * x - x * x / 2);
}

// A beam along x with its block, and the root of the beam.
struct Scene {
    Setup setup;
    Place root;
};

Scene built(const SceneOptions& options)
{
    const double dx = 1.0 / options.cells;
    const int thick = int(std::lround(high * options.cells));
    Scene all{
        between_walls({4 + options.cells + 2, thick + 8, thick + 4}, dx, ContactMode::sticky, 0),
        {}};
    Setup& s = all.setup;
    s.gravity = {0, -g, 0};
    all.root = s.walls.min + dx * Place{4, 4, 2};
    fill_by(s, options, elastic(young, 0, density), all.root, all.root + Place{beam, high, high});
    Place end = s.walls.max;
    end.x = all.root.x;
    // Same speed of sound, so that the beam determines the substep.
    fill_by(s, options, elastic(1000 * young, 0, 1000 * density), s.walls.min, end);
    return all;
}

// Deflection as a multiple of bent() [1], and its rate [1/s], relative to the block.
struct Bend {
    double way, rate;
};
Bend bend_of(const std::vector<Particle<double>>& now, const std::vector<Particle<double>>& first,
             const Scene& scene)
{
    Bend sum{};
    double squares = 0, block_way = 0, block_rate = 0, beside = 0, shapes = 0;
    for (std::size_t i = 0; i < now.size(); ++i) {
        const Place from = first[i].x - scene.root;
        const double down = first[i].x.y - now[i].x.y, rate = -now[i].v.y;
        if (first[i].object == 0) {
            const double w = bent(from.x);
            sum.way += w * down, sum.rate += w * rate, squares += w * w, shapes += w;
        } else if (from.y > 0 && from.y < high) {
            block_way += down, block_rate += rate, beside += 1;
        }
    }
    return {(sum.way - shapes * block_way / beside) / squares,
            (sum.rate - shapes * block_rate / beside) / squares};
}

FrontResult swung(const Verification& v, const SceneOptions& options)
{
    const Scene scene = built(options);
    // Period of a slender beam [s].
    const double period = 2 * std::numbers::pi / 3.516 * beam * beam /
                          std::sqrt(young * high * high / (12 * density));
    const double step = period / 24;
    double sum = 0, mean = std::nan("");
    int turns = 0;
    Bend before{};
    const auto observe = [&](const Simulator& solver, double t) {
        const Bend now = bend_of(by_id(solver), scene.setup.particles, scene);
        const bool turned = before.rate * now.rate < 0;
        // Ends at the second turning point: the bottom is the first, the top the second.
        const double share = turned ? before.rate / (before.rate - now.rate) : 1;
        if (turns + turned == 2) {
            const double last = before.way + share * (now.way - before.way);
            mean = (sum + share * step * (before.way + last) / 2) / (t - step + share * step);
            return false;
        }
        turns += turned;
        sum += step * (before.way + now.way) / 2;
        before = now;
        return true;
    };
    const Driven driven =
        timed_drive(v, options, scene.setup, step, 1.5 * period, no_tools, observe);
    return {100 * std::fabs(mean - 1), driven.seconds, 0};
}

}  // namespace

FrontScene cantilever_front(Verification& v)
{
    return {"cantilever", "percent", "the deflection of Timoshenko's beam",
            FrontSizes{{8, 16}, {8, 16, 32, 64}, {16, 32, 64, 96}}.of(v),
            [&v](const SceneOptions& options) { return swung(v, options); }};
}

}  // namespace knead
