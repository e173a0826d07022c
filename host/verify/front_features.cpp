// workprecision: what each setting of a scene's file buys, by itself: the default, and the same
// with that setting changed.
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "host/base/interrupt.h"
#include "host/verify/front.h"

namespace knead {
namespace {

struct Change {
    const char* name;
    void (*make)(SceneRule&);
    bool quick;  // is in a quick run, too
};

const Change changes[] = {
    {"defaults", [](SceneRule&) {}, true},
    {"contact.grid false", [](SceneRule& r) { r.grid_contact = false; }, true},
    {"contact.passes 0", [](SceneRule& r) { r.passes = 0; }, true},
    {"contact.passes 1", [](SceneRule& r) { r.passes = 1; }, false},
    {"contact.passes 4", [](SceneRule& r) { r.passes = 4; }, false},
    {"step.courant 0.4", [](SceneRule& r) { r.courant = 0.4; }, false},
    {"step.courant 1", [](SceneRule& r) { r.courant = 1; }, false},
    {"per_cell 4", [](SceneRule& r) { r.per_cell = 4; }, false},
    {"per_cell 16", [](SceneRule& r) { r.per_cell = 16; }, false},
    {"deterministic true", [](SceneRule& r) { r.deterministic = true; }, false},
    {"a lattice's particles, not packed", [](SceneRule& r) { r.packed = false; }, true},
};

// The cells of a scene that says nothing of them; fewer where there is no GPU.
int usual_cells(const Verification& v) { return FrontSizes{{16}, {32}, {64}}.of(v).front(); }

}  // namespace

void feature_rows(Verification& v, const FrontScene& scene)
{
    FrontResult usual;
    for (const Change& change : changes) {
        if (interrupted()) return;
        if (v.quick() && !change.quick) continue;
        SceneRule rule = default_rule(usual_cells(v));
        rule.repeats = v.quick() ? 3 : 5, rule.watch = true;
        change.make(rule);
        const FrontResult r = scene.run(rule);
        if (&change == changes) usual = r;
        const std::string outcome =
            &change == changes
                ? "default"
                : fmt::format("{:+.0f} % error, {:+.0f} % time", 100 * (r.error / usual.error - 1),
                              100 * (r.seconds / usual.seconds - 1));
        v.add(VerifyRow{"what a feature bought: " + scene.name,
                        change.name,
                        outcome,
                        {{"error_" + scene.unit, r.error},
                         {"seconds", r.seconds},
                         {"inside_mm", 1e3 * r.inside},
                         {"cells", double(rule.cells)}}});
        if (!v.options.json && !v.options.quiet)
            fmt::print(
                "    {} at {} cells/m, {:<34} {:>8.3f} {}  {:>9.4f} s  {:>6.2f} mm in tools  {}\n",
                scene.name, rule.cells, change.name, r.error, scene.unit, r.seconds, 1e3 * r.inside,
                outcome);
    }
}

}  // namespace knead
