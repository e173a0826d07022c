// workprecision: error against run time, over cells, substep, particles and precision, of scenes
// that each have a measure of their own (front.h). What no other setting beats in both is the
// front.
#include <fmt/format.h>

#include <algorithm>

#include "host/base/interrupt.h"
#include "host/base/machine.h"
#include "host/verify/front.h"

namespace knead {
namespace {

constexpr int usual_per_axis = 2;

struct Point {
    FrontRule rule;
    double error, seconds;  // in the scene's unit, [s]
    int per_cell() const { return rule.per_axis * rule.per_axis * rule.per_axis; }
    bool usual() const
    {
        return rule.per_axis == usual_per_axis && rule.courant == StepRule{}.courant &&
               !rule.in_double;
    }
    std::string name() const
    {
        return fmt::format("{} cells/m, {} a cell, courant {}, {}", rule.cells, per_cell(),
                           rule.courant, rule.in_double ? "double" : "float");
    }
    bool beats(const Point& other) const
    {
        return seconds <= other.seconds && error <= other.error &&
               (seconds < other.seconds || error < other.error);
    }
};

std::vector<FrontRule> rules(const FrontScene& scene, bool quick)
{
    const double usual = StepRule{}.courant;
    std::vector<FrontRule> all;
    for (std::size_t i = 0; i < scene.cells.size(); ++i) {
        const int cells = scene.cells[i];
        for (const double courant :
             quick ? std::vector{0.4, usual} : std::vector{0.2, 0.4, 0.6, usual, 1.0})
            for (const int per_axis : {1, 2, 3})
                if (per_axis < 3 || i == 0 || !quick)
                    all.push_back({cells, per_axis, courant, false});
        // The loops in double are no way to wait for fine cells.
        if (i == 0 || (i == 1 && !quick)) all.push_back({cells, usual_per_axis, usual, true});
    }
    return all;
}

// The quickest that is no worse than `one`, if it is quicker by a tenth, which chance is not; of
// what a scene's file may ask for: not of one particle a cell.
const Point& quickest(const std::vector<Point>& all, const Point& one)
{
    const Point* best = &one;
    for (const Point& p : all) {
        const bool allowed = p.per_cell() > 1 && p.seconds < 0.9 * one.seconds;
        if (allowed && p.error <= one.error && p.seconds < best->seconds) best = &p;
    }
    return *best;
}

// What else is as right as the defaults in less time; and that finer cells are worth their time.
void name_defaults(Verification& v, const FrontScene& scene, const std::vector<Point>& all)
{
    std::vector<Point> defaults;
    std::copy_if(all.begin(), all.end(), std::back_inserter(defaults),
                 [](const Point& p) { return p.usual(); });
    const Point &coarse = defaults.front(), &fine = defaults.back();
    Check c = at_most(fmt::format("{}, defaults: error at {} cells/m over that at {}", scene.name,
                                  fine.rule.cells, coarse.rule.cells),
                      fine.error / coarse.error, 0.7, "", "use the coarser cells");
    c.note = "off " + scene.against;
    for (const Point& p : defaults) {
        const Point& best = quickest(all, p);
        c.note += fmt::format("; at {} cells/m {:.3g} {} in {:.3f} s", p.rule.cells, p.error,
                              scene.unit, p.seconds);
        if (&best != &p)
            c.note += fmt::format(", beaten by {}: {:.3g} {} in {:.3f} s", best.name(), best.error,
                                  scene.unit, best.seconds);
    }
    v.add(c);
}

void add_rows(Verification& v, const FrontScene& scene, const std::vector<Point>& all)
{
    for (const Point& p : all) {
        const auto beaten = [&](const Point& other) { return other.beats(p); };
        const auto by = std::find_if(all.begin(), all.end(), beaten);
        v.add(VerifyRow{"error against run time: " + scene.name,
                        p.name(),
                        by == all.end() ? "front" : "beaten by " + by->name(),
                        {{"error_" + scene.unit, p.error},
                         {"seconds", p.seconds},
                         {"cells", double(p.rule.cells)},
                         {"per_cell", double(p.per_cell())},
                         {"courant", p.rule.courant},
                         {"double", double(p.rule.in_double)},
                         {"default", double(p.usual())}}});
        if (by == all.end() && !v.options.json && !v.options.quiet)
            fmt::print("    {}, front: {:<46} {:>8.3f} {}  {:>8.3f} s\n", scene.name, p.name(),
                       p.error, scene.unit, p.seconds);
    }
}

}  // namespace

std::unique_ptr<Solver> solver_by(const Verification& v, const FrontRule& rule, Setup setup)
{
    if (rule.courant > 0) setup.step.courant = rule.courant;
    return rule.in_double ? v.reference(std::move(setup)) : v.solver(std::move(setup));
}

double timed_drive(Solver& solver, double frame, double end,
                   const std::function<bool(double)>& look)
{
    double looked = 0;
    const double begun = wall_seconds();
    drive(solver, frame, end, [&](double t) {
        const double now = wall_seconds();
        const bool goes_on = look(t);
        looked += wall_seconds() - now;
        return goes_on;
    });
    return wall_seconds() - begun - looked;
}

FrontScene squeeze_front(Verification& v)
{
    return against_finest(v, "squeeze", "the places", v.quick() ? 64 : 96, 32, squeezed,
                          places_off);
}

void front_part(Verification& v)
{
    for (const auto& make :
         {squeeze_front, imprint_front, cantilever_front, sloshing_front, pile_front}) {
        const FrontScene scene = make(v);
        std::vector<Point> all;
        for (const FrontRule& rule : rules(scene, v.quick())) {
            if (interrupted()) return;
            const FrontResult r = scene.run(rule);
            all.push_back({rule, r.error, r.seconds});
            v.say(fmt::format("{}: {}: {:.3f} {}, {:.2f} s", scene.name, all.back().name(), r.error,
                              scene.unit, r.seconds));
        }
        add_rows(v, scene, all);
        name_defaults(v, scene, all);
    }
}

}  // namespace knead
