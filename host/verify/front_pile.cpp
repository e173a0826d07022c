// workprecision: a column of dry sand collapses into a pile. Its profile, as mean heights over
// rings of the floor, against that on a finer lattice.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "host/scene/presets.h"
#include "host/verify/front.h"

namespace knead {
namespace {

constexpr int rings = 9;
constexpr double wide = 0.05, radius = 0.15, high = 0.2, end = 0.6;  // [m] [s]

struct Pile {
    std::array<double, rings> height{};  // [m]
    double seconds = 0, inside = 0;
};

Pile collapsed(const Verification& v, const SceneOptions& options)
{
    const double dx = 1.0 / options.cells;
    Setup s = between_walls({options.cells, options.cells / 2, options.cells}, dx,
                            ContactMode::separate, 0.5);
    s.gravity = {0, -9.81, 0};
    const Place floor = floor_of(s);
    fill_by(s, options,
            made({.name = "dry sand",
                  .elasticity = Elasticity::hencky,
                  .plasticity = Plasticity::drucker_prager,
                  .density = 1600,
                  .young = 3e5,
                  .poisson = 0.3,
                  .friction_angle = 35}),
            s.walls.min, s.walls.max, [&](Place x) {
                return std::min(radius - std::hypot(x.x - floor.x, x.z - floor.z),
                                floor.y + high - x.y);
            });
    // Volume of a particle: the stepped column differs slightly from the exact volume.
    const double share = std::numbers::pi * radius * radius * high / double(s.particles.size());
    const Driven driven = timed_drive(v, options, s, 1.0 / 60, end, no_tools, no_look);
    Pile pile;
    pile.seconds = driven.seconds;
    for (const Particle<double>& q : driven.solver->particles()) {
        const auto i = std::size_t(std::hypot(q.x.x - floor.x, q.x.z - floor.z) / wide);
        const double area = std::numbers::pi * wide * wide * double(2 * i + 1);
        if (i < rings) pile.height[i] += share / area;
    }
    return pile;
}

// Rms height difference over the area of all rings [m].
double apart(const Pile& a, const Pile& b)
{
    double sum = 0, area = 0;
    for (std::size_t i = 0; i < rings; ++i) {
        const double off = a.height[i] - b.height[i], ring = double(2 * i + 1);
        sum += ring * off * off, area += ring;
    }
    return std::sqrt(sum / area);
}

}  // namespace

FrontScene pile_front(Verification& v)
{
    return against_finest(v, "pile of sand", "the profile", 32, 24, collapsed,
                          [](const Pile& a, const Pile& b) { return apart(a, b); });
}

}  // namespace knead
