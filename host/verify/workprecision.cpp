// workprecision: error against run time of the squeeze, over cells, substep, particles and
// precision. The error is the distance of the clay's places from those on a finer lattice, rigid
// motion taken out. What no other case beats in both is the front.
#include <fmt/format.h>

#include <algorithm>

#include "host/verify/squeeze.h"

namespace knead {
namespace {

struct Point {
    SqueezeRule rule;
    double seconds, error;  // [s] [m]
    std::string name() const
    {
        return fmt::format("{} cells/m, {} a cell, courant {}, {}", rule.cells,
                           rule.per_axis * rule.per_axis * rule.per_axis, rule.courant,
                           rule.in_double ? "double" : "float");
    }
    bool beats(const Point& other) const
    {
        return seconds <= other.seconds && error <= other.error &&
               (seconds < other.seconds || error < other.error);
    }
};

std::vector<SqueezeRule> rules(bool quick)
{
    const double usual = StepRule{}.courant;
    std::vector<SqueezeRule> all;
    for (const int cells : quick ? std::vector{16, 32} : std::vector{16, 24, 32, 48}) {
        for (const double courant :
             quick ? std::vector{0.4, 0.6, usual} : std::vector{0.2, 0.4, 0.6, usual, 1.0})
            for (const int per_axis : {1, 2, 3}) all.push_back({cells, per_axis, courant, false});
        if (cells == 16 || cells == 32) all.push_back({cells, 2, usual, true});
    }
    return all;
}

// The quickest that is no worse than `one`.
const Point& quickest(const std::vector<Point>& all, const Point& one)
{
    const Point* best = &one;
    for (const Point& p : all)
        if (p.error <= one.error && p.seconds < best->seconds) best = &p;
    return *best;
}

// What else is as right as the defaults in less time; and that finer cells are worth their time.
void name_defaults(Verification& v, const std::vector<Point>& all)
{
    const StepRule usual;
    std::vector<Point> defaults;
    for (const Point& p : all)
        if (p.rule.per_axis == 2 && p.rule.courant == usual.courant && !p.rule.in_double)
            defaults.push_back(p);
    const Point &coarse = defaults.front(), &fine = defaults.back();
    Check c = at_most(fmt::format("defaults: error at {} cells/m over that at {}", fine.rule.cells,
                                  coarse.rule.cells),
                      fine.error / coarse.error, 0.7, "", "use the coarser cells");
    for (const Point& p : defaults) {
        const Point& best = quickest(all, p);
        c.note += fmt::format("{}at {} cells/m {:.2f} mm in {:.3f} s", c.note.empty() ? "" : "; ",
                              p.rule.cells, 1e3 * p.error, p.seconds);
        if (&best != &p)
            c.note += fmt::format(", beaten by {}: {:.2f} mm in {:.3f} s", best.name(),
                                  1e3 * best.error, best.seconds);
    }
    v.add(c);
}

}  // namespace

void front_part(Verification& v)
{
    const Squeezed finest = squeezed(v, {v.quick() ? 64 : 96, 2, 0, false});
    std::vector<Point> all;
    for (const SqueezeRule& rule : rules(v.quick())) {
        const Squeezed s = squeezed(v, rule);
        all.push_back({rule, s.seconds, apart(s, finest).rms});
        v.say(fmt::format("{}: {:.3f} mm, {:.2f} s", all.back().name(), 1e3 * all.back().error,
                          s.seconds));
    }
    for (const Point& p : all) {
        const auto beaten = [&](const Point& other) { return other.beats(p); };
        const auto by = std::find_if(all.begin(), all.end(), beaten);
        v.add(VerifyRow{"error against run time",
                        p.name(),
                        by == all.end() ? "front" : "beaten by " + by->name(),
                        {{"error_mm", 1e3 * p.error}, {"seconds", p.seconds}}});
        if (by == all.end() && !v.options.json && !v.options.quiet)
            fmt::print("    front: {:<46} {:>8.3f} mm  {:>8.3f} s\n", p.name(), 1e3 * p.error,
                       p.seconds);
    }
    name_defaults(v, all);
}

}  // namespace knead
