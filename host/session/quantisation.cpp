#include "host/session/quantisation.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace knead {
namespace {

// Multiples of the step between two faces, as floats: those that SceneState accepts.
void between_faces(double low, double high, double dx, QuantStep step, float& first, float& last)
{
    const auto inside = [&](double multiple) {
        const double at = double(float(multiple) * step.size);
        const auto rounding = [dx](double face) { return 0.5e-6 * std::fmax(dx, std::fabs(face)); };
        return at >= low - rounding(low) && at <= high + rounding(high);
    };
    double from = std::floor(low / double(step.size)), to = std::ceil(high / double(step.size));
    while (from < to && !inside(from)) ++from;
    while (from < to && !inside(to)) --to;
    first = float(from), last = float(to);
}

// The strains of up to this many particles at a time stay in the first cache.
constexpr std::size_t few = 256;

// quantised() for the strains of `n` particles, whose numbers are `apart` from each other: the
// loops are vectorised.
void round_strains(float* at, std::size_t apart, const std::array<float, few>& sizes, std::size_t n)
{
    std::array<std::array<float, few>, 6> now;
    for (std::size_t p = 0; p < now.size(); ++p)
        for (std::size_t i = 0; i < n; ++i)
            now[p][i] = quantised(at[p * apart + i], quant_step(sizes[i]));
    int impossible = 0;
    for (std::size_t i = 0; i < n; ++i)
        impossible |= int(
            !positive_definite({now[0][i], now[1][i], now[2][i], now[3][i], now[4][i], now[5][i]}));
    for (std::size_t i = 0; impossible && i < n; ++i) {
        const Sym3<float> e{at[i],
                            at[apart + i],
                            at[2 * apart + i],
                            at[3 * apart + i],
                            at[4 * apart + i],
                            at[5 * apart + i]};
        const Sym3<float> q = quantised(e, quant_step(sizes[i]));
        now[0][i] = q.xx, now[1][i] = q.yy, now[2][i] = q.zz;
    }
    for (std::size_t p = 0; p < now.size(); ++p) std::copy_n(now[p].data(), n, at + p * apart);
}

}  // namespace

Quantisation quantisation_of(const SimulationConfig& config)
{
    Quantisation steps;
    const double dx = config.lattice.dx;
    const WallOptions& walls = config.walls;
    const double far =
        std::max({std::fabs(walls.min.x), std::fabs(walls.min.y), std::fabs(walls.min.z),
                  std::fabs(walls.max.x), std::fabs(walls.max.y), std::fabs(walls.max.z)});
    steps.x = float(dx / x_steps_a_cell);
    while (far / double(steps.x) > double(most_multiple) / 2) steps.x *= 2;
    const QuantStep x = quant_step(steps.x);
    between_faces(walls.min.x, walls.max.x, dx, x, steps.low.x, steps.high.x);
    between_faces(walls.min.y, walls.max.y, dx, x, steps.low.y, steps.high.y);
    between_faces(walls.min.z, walls.max.z, dx, x, steps.low.z, steps.high.z);
    for (const Material<double>& m : config.materials) {
        const bool softens = m.plasticity == Plasticity::von_mises && m.hardening < 0;
        steps.e.push_back(e_step_of(m.mu, softens ? std::min(m.yield, m.yield_floor) : m.yield));
    }
    return steps;
}

ClayRows quantised(ClayRows rows, const Quantisation& steps)
{
    const QuantStep x = quant_step(steps.x), k = quant_step(k_step), F = quant_step(F_step);
    const std::size_t n = rows.count;
    float* const plane = rows.planes.data();
    const float low[] = {steps.low.x, steps.low.y, steps.low.z},
                high[] = {steps.high.x, steps.high.y, steps.high.z};
    for (std::size_t a = 0; a < 3; ++a)
        for (std::size_t i = 0; i < n; ++i)
            plane[a * n + i] = quantised_between(plane[a * n + i], x, low[a], high[a]);
    std::array<float, few> e;
    for (std::size_t first = 0; first < n; first += few) {
        const std::size_t some = std::min(few, n - first);
        for (std::size_t i = 0; i < some; ++i) e[i] = steps.of_object(rows.object[first + i]);
        round_strains(plane + 3 * n + first, n, e, some);
    }
    for (std::size_t i = 0; i < n; ++i) plane[9 * n + i] = quantised(plane[9 * n + i], k);
    for (Gaussian<float>& g : rows.gaussians) {
        g.x = {quantised_between(g.x.x, x, low[0], high[0]),
               quantised_between(g.x.y, x, low[1], high[1]),
               quantised_between(g.x.z, x, low[2], high[2])};
        for (Vec3<float>* column : {&g.F.a, &g.F.b, &g.F.c})
            *column = {quantised(column->x, F), quantised(column->y, F), quantised(column->z, F)};
    }
    return rows;
}

}  // namespace knead
