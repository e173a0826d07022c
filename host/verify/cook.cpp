// convergence: Cook's membrane, held at one edge and sheared at the other.
#include <fmt/format.h>

#include <cmath>

#include "host/verify/cases.h"

namespace knead {
namespace {

// In Cook's units, 1 cm each: a plate from x = 0, where it is 44 high, to x = 48, where it is 16
// high with its top at y = 60. A shear force F on that end moves its upper corner by 23.96 F / (E
// t) in plane stress for nu = 1/3 [Cook 1974; Simo & Rifai 1990].
constexpr double unit = 0.01, wide = 48 * unit, top = 60 * unit;  // [m]
constexpr double young = 1e6, poisson = 1.0 / 3, density = 1000;  // [Pa] [kg/m^3]
constexpr double way = 0.5 * unit;                                // displacement of the corner [m]
// Angular frequency of the lowest mode, approximately [1/s].
const double lowest = 0.0108 / unit * std::sqrt(young / density);

bool in_plate(Place x)
{
    const double share = std::fmax(x.x, 0) / wide, low = 44 * unit * share;
    return x.y > low && x.y < low + (44 - 28 * share) * unit;
}

// Four cells thick, welded to a block a thousand times as stiff and so heavy that it hardly moves.
Setup membrane(int cells, Place& origin)
{
    const double dx = wide / cells;
    Setup s = between_walls({cells + 12, int(top / dx) + 10, 10}, dx, ContactMode::separate, 0);
    origin = s.walls.min + Place{8 * dx, 4 * dx, 3 * dx};
    const auto part = [&](const Material<double>& m, double from, double to) {
        fill(s, m, origin + Place{from, 0, 0}, origin + Place{to, std::ceil(top / dx) * dx, 4 * dx},
             2, [&](Place x) { return in_plate(x - origin); });
    };
    part(elastic(young, poisson, density), 0, wide);
    part(elastic(1e3 * young, poisson, 1e5 * density), -4 * dx, 0);
    return s;
}

// Displacement of the corner over the reference after the plate has come to rest. The force acts on
// the last cells before the end.
double moved(Verification& v, int cells)
{
    const double dx = wide / cells, force = way / 23.96 * young * 4 * dx;
    Place origin;
    const Setup s = membrane(cells, origin);
    std::vector<std::size_t> pulled, corner;
    for (std::size_t i = 0; i < s.particles.size(); ++i) {
        const Place x = s.particles[i].x - origin;
        if (x.x > wide - dx) pulled.push_back(i);
        if (x.x > wide - dx && x.y > top - 1.5 * dx) corner.push_back(i);
    }
    const double frame = dx / std::sqrt(young / density), end = 3 * M_PI / lowest,
                 keep = std::exp(-2 * lowest * frame),  // critical damping of the lowest mode
        kick = frame * force / (s.materials[0].mass * double(pulled.size()));
    auto solver = v.solver(s);
    for (double t = 0; t < end; t += frame) {
        change(v, solver, s, [&](std::vector<Particle<double>>& all) {
            for (Particle<double>& q : all) q.v = keep * q.v, q.C = keep * q.C;
            for (const std::size_t i : pulled) all[i].v.y += kick;
        });
        solver->advance({}, frame);
    }
    const std::vector<Particle<double>> now = by_id(*solver);
    double sum = 0;
    for (const std::size_t i : corner) sum += now[i].x.y - s.particles[i].x.y;
    return sum / double(corner.size()) / way;
}

}  // namespace

// Slanted edges are stepped, and the clamped edge is resolved to a cell: required are first order
// and, on the finer cells, the 5 % usual of coarse finite elements.
void cook_part(Verification& v)
{
    const int cells = v.quick() ? 8 : 12;
    const double rough = 100 * moved(v, cells) - 100, fine = 100 * moved(v, 2 * cells) - 100;
    v.add(near(fmt::format("Cook's membrane, {} cells wide: corner's way, off", 2 * cells), fine, 0,
               5, "%", "held parts bend too little: refine"));
    Check c = at_least("Cook's membrane: order of that error", std::log2(std::fabs(rough / fine)),
                       1, "", "refining held parts does not help");
    c.note = fmt::format("{:.3g} % at {} cells, {:.3g} % at {}", rough, cells, fine, 2 * cells);
    v.add(c);
}

}  // namespace knead
