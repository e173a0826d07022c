#include "host/verify/bars.h"

#include <cmath>
#include <numbers>

namespace knead::bars {
using std::numbers::pi;

Setup free_bar(int cells, int thick, double poisson)
{
    const double h = bar / cells;
    Setup s = between_walls({cells + 8, thick + 8, thick + 8}, h, ContactMode::separate, 0);
    const Place low = s.walls.min + Place{4 * h, 4 * h, 4 * h};
    fill(s, elastic(young, poisson, density), low, low + Place{bar, thick * h, thick * h}, 2);
    return s;
}

Place corner_of(const Setup& s)
{
    const double quarter = s.lattice.dx / 4;  // half the edge of a particle's cube
    return s.particles.front().x - Place{quarter, quarter, quarter};
}

Ringing ringing(const std::vector<double>& u, double step)
{
    std::vector<double> zeros;
    for (std::size_t i = 1; i < u.size(); ++i)
        if (u[i - 1] * u[i] < 0)
            zeros.push_back(step * (double(i - 1) + u[i - 1] / (u[i - 1] - u[i])));
    if (zeros.size() < 9) return {std::nan(""), std::nan("")};
    const double T = (zeros[8] - zeros[0]) / 4, w = 2 * pi / T;
    const auto amplitude = [&](double from) {
        const auto n = std::size_t(std::lround(T / step)), first = std::size_t(from / step);
        double c = 0, s = 0;
        for (std::size_t i = first; i < first + n && i < u.size(); ++i)
            c += u[i] * std::cos(w * step * double(i)), s += u[i] * std::sin(w * step * double(i));
        return std::hypot(c, s);
    };
    return {T, amplitude(4 * T) / amplitude(0)};
}

void set_velocities(Setup& s, const Field& field, double share)
{
    const Place corner = corner_of(s);
    const double step = 1e-4 * bar;
    for (Particle<double>& q : s.particles) {
        const Place r = q.x - corner;
        const auto slope = [&](Place way) {
            return (share / (2 * step)) * (field(r + way) - field(r - way));
        };
        q.v = share * field(r);
        q.C = {slope({step, 0, 0}), slope({0, step, 0}), slope({0, 0, step})};
    }
}

Ringing rung(Verification& v, Setup s, double expected, const Field& field)
{
    const Place corner = corner_of(s);
    std::vector<Vec3<double>> shape;
    for (const Particle<double>& q : s.particles) shape.push_back(field(q.x - corner));
    set_velocities(s, field, 1e-3);
    const auto solver = v.solver(s);
    const double step = expected / std::ceil(12.5 * bar / s.lattice.dx * 0.4);
    std::vector<double> all;
    drive(*solver, step, 5.2 * expected, [&](double) {
        double sum = 0;
        const std::vector<Particle<double>> now = by_id(*solver);
        for (std::size_t i = 0; i < now.size(); ++i) sum += dot(shape[i], now[i].v);
        all.push_back(sum);
        return true;
    });
    return ringing(all, step);
}

}  // namespace knead::bars
