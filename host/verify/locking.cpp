// convergence: bending of a free beam under a given load, up to nearly incompressible clay.
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "host/verify/bars.h"
#include "host/verify/cases.h"

namespace knead {
namespace {
using std::numbers::pi;
using namespace bars;

// A force b cos(k x) per mass, k = 2 pi / L, has zero sum and moment, so no support is needed. By
// Timoshenko w = q / (E I k^4) (cos(k x) + k^2 (x - L/2)^2 / 2) + q / (kappa G A k^2) cos(k x) with
// q = density A b; measured is its mean product with cos(k x) [m]. Square section of edge h.
double bends_by(double b, double h, double poisson)
{
    const double k = 2 * pi / bar, G = young / (2 * (1 + poisson));
    const double kappa = 10 * (1 + poisson) / (12 + 11 * poisson);  // [Cowper 1966]
    return density * b * (1.5 * 12 / (young * h * h * k * k * k * k) + 0.5 / (kappa * G * k * k));
}

// Mean product of the deflection with cos(k x), over theory, after the beam has come to rest.
double bent(Verification& v, int thick, double poisson)
{
    const double h = 1.0 / 8, c = std::sqrt(young / density);
    const double load = 0.01 * h / bends_by(1, h, poisson);
    Setup s = free_bar(8 * thick, thick, poisson);
    const Place corner = corner_of(s);
    std::vector<double> shape;
    for (const Particle<double>& q : s.particles)
        shape.push_back(std::cos(2 * pi * (q.x.x - corner.x) / bar));
    const double w = 22.37 * h / std::sqrt(12.0) * c / (bar * bar);  // of the lowest mode [1/s]
    const double frame = s.lattice.dx / c, end = 3 * pi / w;
    auto solver = v.solver(s);
    for (double t = 0; t < end; t += frame) {
        change(v, solver, s, [&](std::vector<Particle<double>>& all) {
            const double keep = std::exp(-2 * w * frame);  // critical damping
            for (std::size_t i = 0; i < all.size(); ++i) {
                all[i].v = keep * all[i].v + Vec3<double>{0, frame * load * shape[i], 0};
                all[i].C = keep * all[i].C;
            }
        });
        solver->advance({}, frame);
    }
    double sum = 0;
    const std::vector<Particle<double>> now = by_id(*solver);
    for (std::size_t i = 0; i < now.size(); ++i)
        sum += shape[i] * (now[i].x.y - s.particles[i].x.y);
    return sum / double(now.size()) / (0.01 * h);
}

}  // namespace

// Nearly incompressible clay must bend as far as any other; a smaller deflection is volumetric
// locking.
void locking_part(Verification& v)
{
    constexpr int thick = 4;
    const double usual = bent(v, thick, 0.3);
    v.add(near("beam 4 cells thick, nu = 0.3: bends, of theory", 100 * usual, 100, 5, "%",
               "thin parts bend too easily or too hard: refine"));
    const std::vector<double> others =
        v.quick() ? std::vector{0.499} : std::vector{0.45, 0.49, 0.499};
    for (const double poisson : others)
        v.add(near(fmt::format("beam 4 cells thick, nu = {}: bends, of that at 0.3", poisson),
                   100 * bent(v, thick, poisson) / usual, 100, 3, "%",
                   "keep Poisson's ratio at 0.49 or below"));
}

}  // namespace knead
