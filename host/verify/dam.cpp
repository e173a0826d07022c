// accuracy: collapse of a liquid column between walls, against the experiment.
#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "host/verify/clay.h"
#include "host/verify/verify.h"

namespace knead {
namespace {

constexpr double g = 9.81, wide = 0.05715;  // 2.25 in [m]

// Front over column width and time over sqrt(a / 2g), for a column twice as high as wide [Martin &
// Moyce 1952, figure 3, a = 2.25 in].
constexpr double measured[][2] = {
    {0.832, 1.217}, {1.219, 1.474}, {1.997, 2.292}, {2.547, 2.995}, {3.345, 4.134}};

// The front is the far side of the foremost particle. Water has no strength and little viscosity;
// its speed of sound, 20 sqrt(g a), is seven times its maximum speed. Friction, which slows the
// front of the experiment slightly, is neglected.
void column(Verification& v, int cells)
{
    const double dx = wide / cells, unit = std::sqrt(wide / (2 * g));
    Setup s = between_walls({5 * cells, 2 * cells + 4, 4}, dx, ContactMode::slip, 0);
    s.gravity = {0, -g, 0};
    Material<double> m{};
    m.plasticity = Plasticity::fluid;
    m.density = 1000, m.bulk = m.density * 400 * g * wide, m.exponent = 7, m.viscosity = 1e-3;
    const Place low = s.walls.min;
    fill(s, m, low, {low.x + wide, low.y + 2 * wide, s.walls.max.z}, 2);
    const auto solver = v.solver(s);
    double time = 0;
    for (const auto& [t, expected] : measured) {
        drive(*solver, unit / 20, t * unit - time, [](double) { return true; });
        time = t * unit;
        double front = 0;
        for (const Particle<double>& q : solver->particles())
            front = std::fmax(front, (q.x.x + dx / 4 - low.x) / wide);
        v.add(near(fmt::format("dam, {} cells wide: front at t sqrt(2g/a) = {}", cells, t), front,
                   expected, 0.1 * expected, "a",
                   "water runs ahead by a tenth: give walls friction, up to 0.3"));
    }
}

}  // namespace

void dam_part(Verification& v)
{
    for (const int cells : v.quick() ? std::vector{12} : std::vector{12, 24}) column(v, cells);
}

}  // namespace knead
