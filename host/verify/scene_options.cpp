#include "host/verify/scene_options.h"

#include <algorithm>
#include <cmath>

#include "host/base/machine.h"
#include "host/scene/packing.h"

namespace knead {
namespace {

constexpr double short_run = 0.5;  // runs shorter than this are repeated [s]

double box_depth(Place x, Place from, Place to)
{
    const Place a = x - from, b = to - x;
    return std::min({a.x, a.y, a.z, b.x, b.y, b.z});
}

std::unique_ptr<Simulator> solver_by(const Verification& v, const SceneOptions& options,
                                     const Setup& setup)
{
    return options.in_double ? v.reference(setup) : v.solver(setup);
}

// Strata of edge h between `from` and `to` that may lie partly below the surface.
Packing around(double h, Place from, Place to, const std::function<double(Place)>& under)
{
    const auto stratum = [h](Place x) {
        return Int3{int(std::floor(x.x / h)), int(std::floor(x.y / h)), int(std::floor(x.z / h))};
    };
    const Int3 first = stratum(from), last = stratum(to);
    Int3 low = last, high = first;
    for (int z = first.z; z <= last.z; ++z)
        for (int y = first.y; y <= last.y; ++y)
            for (int x = first.x; x <= last.x; ++x) {
                if (under(h * Place{x + 0.5, y + 0.5, z + 0.5}) < -h) continue;
                low = {std::min(low.x, x), std::min(low.y, y), std::min(low.z, z)};
                high = {std::max(high.x, x), std::max(high.y, y), std::max(high.z, z)};
            }
    Packing p;
    p.h = h, p.low = low, p.high = high + Int3{1, 1, 1};
    return p;
}

std::vector<Place> places_of(const SceneOptions& options, int object, double h, Place from,
                             Place to, const std::function<double(Place)>& under)
{
    std::vector<Place>* kept =
        options.seeds ? &(*options.seeds)[{object, options.cells, options.per_cell}] : nullptr;
    if (kept && !kept->empty()) return *kept;
    Packing packing = around(h, from, to, under);
    packing.per_cell = options.per_cell, packing.object = std::size_t(object);
    std::vector<Place> all = packed(packing, under);
    if (kept) *kept = all;
    return all;
}

int pack(Setup& s, const SceneOptions& options, Material<double> material, Place from, Place to,
         const std::function<double(Place)>& under)
{
    const double h = s.lattice.dx / std::cbrt(options.per_cell);
    material.volume = h * h * h;
    material.mass = material.density * material.volume;
    const auto object = int(s.materials.size());
    s.materials.push_back(material);
    const auto within = [&](Place x) { return std::min(box_depth(x, from, to), under(x)); };
    for (const Place& x : places_of(options, object, h, from, to, within)) {
        Particle<double> q{};
        q.x = x, q.object = object;
        s.particles.push_back(q);
    }
    return object;
}

}  // namespace

int fill_by(Setup& s, const SceneOptions& options, Material<double> material, Place from, Place to,
            const std::function<double(Place)>& depth)
{
    if (options.packed) return pack(s, options, material, from, to, depth);
    return fill(s, material, from, to, int(std::lround(std::cbrt(options.per_cell))),
                [&](Place x) { return depth(x) > 0; });
}

int fill_by(Setup& s, const SceneOptions& options, Material<double> material, Place from, Place to)
{
    return fill_by(s, options, material, from, to, [](Place) { return 1e9; });
}

Driven timed_drive(const Verification& v, const SceneOptions& options, Setup s, double frame,
                   double end, const std::function<std::vector<Joint<double>>(double)>& at,
                   const std::function<bool(const Simulator&, double)>& observe)
{
    if (options.courant > 0) s.step.courant = options.courant;
    s.grid_contact = options.grid_contact, s.passes = options.passes;
    s.deterministic = options.deterministic;
    Driven all;
    all.solver = solver_by(v, options, s);
    double looked = 0, last = 0;
    double begun = wall_seconds();
    all.stats = drive(*all.solver, frame, end, at, [&](double t) {
        const double now = wall_seconds();
        if (options.watch)
            for (const double d : all.solver->penetration()) all.inside = std::fmax(all.inside, d);
        const bool goes_on = observe(*all.solver, t);
        last = t;
        looked += wall_seconds() - now;
        return goes_on;
    });
    all.seconds = wall_seconds() - begun - looked;
    for (int i = 1; i < options.repeats && all.seconds < short_run; ++i) {
        const auto again = solver_by(v, options, s);
        begun = wall_seconds();
        drive(*again, frame, last, at, [](double) { return true; });
        all.seconds = std::fmin(all.seconds, wall_seconds() - begun);
    }
    return all;
}

}  // namespace knead
