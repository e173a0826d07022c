// workprecision: error against run time over cells, substep, particles and precision, for scenes
// with a measure each (front.h). The Pareto front contains the settings that no other setting beats
// in both.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/base/interrupt.h"
#include "host/base/print.h"
#include "host/verify/front.h"

namespace knead {
namespace {

constexpr double tenth = 0.9;  // ratio below which a result counts as better, beyond chance

// Particles per cell and Courant numbers for the index-th lattice of a scene.
struct Settings {
    std::vector<double> per_cell, courant;
};
Settings settings(const Verification& v, std::size_t index, std::size_t lattices)
{
    const double usual = StepOptions{}.courant;
    if (v.quick()) {
        if (index == 0) return {{4, 8, 27}, {0.4, usual}};
        return {{4, 8}, {0.4, usual}};
    }
    const bool finest = index + 1 == lattices && v.device.kind == DeviceKind::cuda;
    if (finest) return {{4, 8, 16}, {0.7, usual}};
    return {{4, 8, 16, 27}, {0.3, 0.5, 0.7, usual}};
}

// True if the device is the reference (loops in double).
bool in_double(const Verification& v) { return v.device.kind == DeviceKind::cpu_double; }

std::vector<SceneOptions> rules(const Verification& v, const FrontScene& scene)
{
    std::vector<SceneOptions> all;
    // The reference omits the finest cells, which take most of the time.
    const std::size_t lattices = scene.cells.size() - (in_double(v) && !v.quick() ? 1 : 0);
    for (std::size_t i = 0; i < lattices; ++i) {
        const Settings s = settings(v, i, scene.cells.size());
        SceneOptions options = default_options(scene.cells[i]);
        options.repeats = v.quick() ? 1 : 3;
        for (const double courant : s.courant)
            for (const double per_cell : s.per_cell) {
                options.courant = courant, options.per_cell = per_cell;
                all.push_back(options);
            }
        // Double precision only on the coarsest cells, because of its run time.
        if (i > 0 || in_double(v)) continue;
        options = default_options(scene.cells[i]), options.in_double = true;
        all.push_back(options);
    }
    return all;
}

// Reports settings better than the defaults, and checks that refinement reduces the error.
void judge_defaults(Verification& v, const FrontScene& scene, const std::vector<FrontPoint>& all)
{
    std::vector<FrontPoint> defaults;
    std::copy_if(all.begin(), all.end(), std::back_inserter(defaults),
                 [](const FrontPoint& p) { return p.usual(); });
    const FrontPoint &coarse = defaults.front(), &fine = defaults.back();
    Check c = at_most(fmt::format("{}, defaults: error at {} cells/m over that at {}", scene.name,
                                  fine.options.cells, coarse.options.cells),
                      fine.error / coarse.error, 0.7, "", "use the coarser cells");
    c.note = "off " + scene.against;
    for (const FrontPoint& p : defaults) {
        const std::string stands = standing(beaten_by(all, p), scene.unit);
        c.note +=
            fmt::format("; at {} cells/m {}, {}", p.options.cells, p.summary(scene.unit), stands);
        v.add(VerifyRow{"defaults: " + scene.name,
                        fmt::format("{} cells/m", p.options.cells),
                        stands,
                        {{"error_" + scene.unit, p.error}, {"seconds", p.seconds}}});
    }
    v.add(c);
}

void add_rows(Verification& v, const FrontScene& scene, const std::vector<FrontPoint>& all)
{
    for (const FrontPoint& p : all) {
        const auto beaten = [&](const FrontPoint& other) { return other.beats(p); };
        const auto by = std::find_if(all.begin(), all.end(), beaten);
        v.add(VerifyRow{"error against run time: " + scene.name,
                        p.name(),
                        by == all.end() ? "front" : "beaten by " + by->name(),
                        {{"error_" + scene.unit, p.error},
                         {"counted", p.counted},
                         {"seconds", p.seconds},
                         {"cells", double(p.options.cells)},
                         {"per_cell", p.options.per_cell},
                         {"courant", p.options.courant},
                         {"double", double(p.options.in_double || in_double(v))},
                         {"default", double(p.usual())}}});
        if (by == all.end() && !v.options.json && !v.options.quiet)
            print(fmt::format("    {}, front: {:<46} {}\n", scene.name, p.name(),
                              p.summary(scene.unit)));
    }
}

}  // namespace

SceneOptions default_options(int cells)
{
    SceneOptions options;
    options.cells = cells, options.courant = StepOptions{}.courant, options.packed = true;
    return options;
}

std::string FrontPoint::name() const
{
    return fmt::format("{} cells/m, {} a cell, courant {}{}", options.cells, options.per_cell,
                       options.courant, options.in_double ? ", in double" : "");
}

std::string FrontPoint::summary(const std::string& unit) const
{
    const std::string luck = counted > error ? fmt::format(" (counts as {:.3g})", counted) : "";
    return fmt::format("{:.3g} {}{} in {:.3g} s", error, unit, luck, seconds);
}

bool FrontPoint::usual() const
{
    const SceneOptions d = default_options(options.cells);
    return options.per_cell == d.per_cell && options.courant == d.courant && !options.in_double;
}

bool FrontPoint::beats(const FrontPoint& other) const
{
    return seconds <= other.seconds && counted <= other.counted &&
           (seconds < other.seconds || counted < other.counted);
}

void count_errors(std::vector<FrontPoint>& all)
{
    for (FrontPoint& p : all) {
        p.counted = 0;
        for (const FrontPoint& q : all)
            if (q.options.per_cell == p.options.per_cell &&
                q.options.courant == p.options.courant &&
                q.options.in_double == p.options.in_double && q.options.cells >= p.options.cells)
                p.counted = std::fmax(p.counted, std::isfinite(q.error) ? q.error : INFINITY);
    }
}

Beaten beaten_by(const std::vector<FrontPoint>& all, const FrontPoint& one)
{
    Beaten by;
    for (const FrontPoint& p : all) {
        if (p.counted <= one.counted && p.seconds < tenth * one.seconds &&
            (!by.quicker || p.seconds < by.quicker->seconds))
            by.quicker = &p;
        if (p.seconds <= one.seconds && p.counted < tenth * one.counted &&
            (!by.righter || p.counted < by.righter->counted))
            by.righter = &p;
    }
    return by;
}

std::string standing(const Beaten& by, const std::string& unit)
{
    if (!by.at_all()) return "on the front";
    const auto summary = [&](const FrontPoint& p) { return p.name() + ": " + p.summary(unit); };
    std::string text = "beaten";
    if (by.quicker) text += " in time by " + summary(*by.quicker);
    if (by.righter && by.righter != by.quicker)
        text += (by.quicker ? " and in error by " : " in error by ") + summary(*by.righter);
    return text;
}

FrontScene squeeze_front(Verification& v)
{
    return against_finest(v, "squeeze", "the places", 64, 32, squeezed, places_off);
}

void front_part(Verification& v)
{
    for (const auto& make :
         {squeeze_front, imprint_front, cantilever_front, sloshing_front, pile_front}) {
        const FrontScene scene = make(v);
        std::vector<FrontPoint> all;
        const auto seeds = std::make_shared<Seeds>();
        for (SceneOptions options : rules(v, scene)) {
            if (interrupted()) return;
            options.seeds = seeds;
            const FrontResult r = scene.run(options);
            all.push_back({options, r.error, r.seconds, r.error});
            v.say(fmt::format("{}: {}: {:.3f} {}, {:.4f} s", scene.name, all.back().name(), r.error,
                              scene.unit, r.seconds));
        }
        count_errors(all);
        add_rows(v, scene, all);
        judge_defaults(v, scene, all);
        if (scene.name == "squeeze" || scene.name == "imprint") feature_rows(v, scene);
    }
    surface_front(v);
}

}  // namespace knead
