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

constexpr std::size_t chunk = 1024;  // particles at a time, which stay in the first cache

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
    std::array<float, chunk> e;
    for (std::size_t first = 0; first < n; first += chunk) {
        const std::size_t some = std::min(chunk, n - first);
        for (std::size_t i = 0; i < some; ++i) e[i] = steps.of_object(rows.object[first + i]);
        float* const at = plane + 3 * n + first;
        for (std::size_t i = 0; i < some; ++i) {
            const Sym3<float> q =
                quantised(Sym3<float>{at[i], at[n + i], at[2 * n + i], at[3 * n + i], at[4 * n + i],
                                      at[5 * n + i]},
                          quant_step(e[i]));
            at[i] = q.xx, at[n + i] = q.yy, at[2 * n + i] = q.zz;
            at[3 * n + i] = q.xy, at[4 * n + i] = q.xz, at[5 * n + i] = q.yz;
        }
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
