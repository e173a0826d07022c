// accuracy: collapse of a column of dry sand, against experiments.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/scene/presets.h"
#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead {
namespace {

constexpr double g = 9.81, radius = 0.1;  // [m/s^2] [m]

Material<double> dry_sand(double angle)
{
    const double density = 1600;
    return made({.name = "dry sand",
                 .elasticity = Elasticity::hencky,
                 .plasticity = Plasticity::drucker_prager,
                 .density = density,
                 .young = 300 * density * g * radius,  // its weight compresses it by 1/600
                 .poisson = 0.3,
                 .friction_angle = angle});
}

// Run-out of a column as high as its radius of `cells` cells [radius].
double run_out(Verification& v, int cells, double angle)
{
    const double dx = radius / cells;
    const int wide = 2 * 3 * cells;
    Setup s = between_walls({wide, cells + 4, wide}, dx, ContactMode::separate, 0.6);
    s.gravity = {0, -g, 0};
    const Place foot = floor_of(s), reach{radius, 0, radius};
    fill(s, dry_sand(angle), foot - reach, foot + reach + Place{0, radius, 0}, 2,
         [&](Place x) { return std::hypot(x.x - foot.x, x.z - foot.z) < radius; });
    const auto solver = v.solver(s);
    const double fall = std::sqrt(radius / g);
    drive(*solver, fall / 4, 6 * fall, [](double) { return true; });
    std::vector<double> out;
    for (const Particle<double>& q : solver->particles())
        out.push_back(std::hypot(q.x.x - foot.x, q.x.z - foot.z));
    std::sort(out.begin(), out.end());
    return (out[out.size() * 999 / 1000] + dx / 4) / radius - 1;  // ignores single grains
}

}  // namespace

// A column as high as its radius r runs out by 1.24 r for any grains; the friction angle of dry
// sand is 31 degrees [Lube et al. 2004; Lajeunesse et al. 2005].
void sand_part(Verification& v)
{
    constexpr double angle = 31;
    const int cells = v.quick() ? 6 : 12;
    v.add(near(fmt::format("sand column, r = {} dx: run-out", cells), run_out(v, cells, angle),
               1.24, 0.3 * 1.24, "r",
               "a column of few cells stands steeper: refine, or state a smaller angle"));
}

}  // namespace knead
