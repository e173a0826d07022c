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
    std::vector<SqueezeRule> all;
    for (const int cells : quick ? std::vector{16, 24} : std::vector{16, 24, 32, 48}) {
        for (const double courant :
             quick ? std::vector{0.2, 0.4, 0.6} : std::vector{0.1, 0.2, 0.4, 0.6, 0.8})
            for (const int per_axis : {1, 2, 3}) all.push_back({cells, per_axis, courant, false});
        if (cells <= 24) all.push_back({cells, 2, 0.4, true});
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

}  // namespace

void front_part(Verification& v)
{
    const Squeezed finest = squeezed(v, {v.quick() ? 48 : 96, 2, 0, false});
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
    const StepRule usual;
    for (const Point& p : all) {
        const bool is_default =
            p.rule.per_axis == 2 && p.rule.courant == usual.courant && !p.rule.in_double;
        if (!is_default) continue;
        const Point& best = quickest(all, p);
        Check c = at_most(
            fmt::format("defaults at {} cells/m: time over the quickest as right", p.rule.cells),
            p.seconds / best.seconds, 2, "", "use the settings that are named");
        if (&best != &p)
            c.note =
                fmt::format("{:.3f} mm in {:.2f} s; {:.3f} mm in {:.2f} s by {}", 1e3 * p.error,
                            p.seconds, 1e3 * best.error, best.seconds, best.name());
        v.add(c);
    }
}

}  // namespace knead
