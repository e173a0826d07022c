// workprecision: liquid in a tank sloshes in its first mode. Small waves on depth H oscillate with
// w^2 = g k tanh(k H) [Lamb 1932], all particles with the same a sin(w t).
#include <cmath>
#include <numbers>

#include "host/verify/front.h"

namespace knead {
namespace {

constexpr double g = 9.81, depth = 0.5, k = std::numbers::pi, high = 0.01;  // [m/s^2] [m] [1/m]

// Velocity of a wave of unit amplitude over its angular frequency, at x from the tank's side and y
// above its floor.
Place wave(Place x)
{
    return (1 / std::sinh(k * depth)) * Place{-std::sin(k * x.x) * std::cosh(k * x.y),
                                              std::cos(k * x.x) * std::sinh(k * x.y), 0};
}

Setup tank(const SceneOptions& options, double w)
{
    const double dx = 1.0 / options.cells;
    Setup s = between_walls({options.cells, options.cells * 3 / 4, 4}, dx, ContactMode::slip, 0);
    s.gravity = {0, -g, 0};
    Material<double> m{};
    m.plasticity = Plasticity::fluid;
    // Speed of sound ten times that of a long wave: 1 % denser at the floor.
    m.density = 1000, m.bulk = m.density * 100 * g * depth, m.exponent = 7, m.viscosity = 0.1;
    const Place low = s.walls.min;
    fill_by(s, options, m, low, {s.walls.max.x, low.y + depth, s.walls.max.z});
    for (Particle<double>& q : s.particles) {
        const Place x = q.x - low;
        const double pressure = m.density * g * (depth - x.y),
                     e = std::pow(1 + 7 * pressure / m.bulk, -2.0 / 21) - 1;
        q.e = {e, e, e, 0, 0, 0};
        q.v = (w * high) * wave(x);
        const double rate = w * high * k / std::sinh(k * depth),
                     along = rate * std::cos(k * x.x) * std::cosh(k * x.y),
                     across = -rate * std::sin(k * x.x) * std::sinh(k * x.y);
        q.C = {{-along, across, 0}, {across, along, 0}, {0, 0, 0}};
    }
    return s;
}

// Over half a period, from flat to flat: rms deviation from theory over the rms of theory.
FrontResult sloshed(const Verification& v, const SceneOptions& options)
{
    const double w = std::sqrt(g * k * std::tanh(k * depth)), end = std::numbers::pi / w;
    const Setup s = tank(options, w);
    std::vector<Place> shape;
    double squares = 0;
    for (const Particle<double>& q : s.particles) {
        shape.push_back(wave(q.x - s.walls.min));
        squares += dot(shape.back(), shape.back());
    }
    double off = 0, whole = 0;
    const Driven driven =
        timed_drive(v, options, s, end / 24, end, no_tools, [&](const Simulator& solver, double t) {
            const std::vector<Particle<double>> now = by_id(solver);
            double sum = 0;
            for (std::size_t i = 0; i < now.size(); ++i)
                sum += dot(shape[i], now[i].x - s.particles[i].x);
            const double expected = high * std::sin(w * t), miss = sum / squares - expected;
            off += miss * miss, whole += expected * expected;
            return true;
        });
    return {100 * std::sqrt(off / whole), driven.seconds, 0};
}

}  // namespace

FrontScene sloshing_front(Verification& v)
{
    return {"sloshing", "percent", "Lamb's standing wave",
            FrontSizes{{8, 16}, {8, 16, 32, 64}, {16, 32, 64, 96}}.of(v),
            [&v](const SceneOptions& options) { return sloshed(v, options); }};
}

}  // namespace knead
