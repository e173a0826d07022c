// workprecision: the effect of each setting of a scene file: the defaults, and the same with one
// setting changed.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "host/base/interrupt.h"
#include "host/base/print.h"
#include "host/verify/front.h"

namespace knead {
namespace {

struct Change {
    const char* name;
    void (*make)(SceneOptions&);
    bool quick;  // also in a quick run
};

const Change changes[] = {
    {"defaults", [](SceneOptions&) {}, true},
    {"contact.grid false", [](SceneOptions& r) { r.grid_contact = false; }, true},
    {"contact.passes 0", [](SceneOptions& r) { r.passes = 0; }, true},
    {"contact.passes 2", [](SceneOptions& r) { r.passes = 2; }, false},
    {"contact.passes 4", [](SceneOptions& r) { r.passes = 4; }, false},
    {"step.courant 0.4", [](SceneOptions& r) { r.courant = 0.4; }, false},
    {"step.courant 0.7", [](SceneOptions& r) { r.courant = 0.7; }, false},
    {"per_cell 4", [](SceneOptions& r) { r.per_cell = 4; }, false},
    {"per_cell 16", [](SceneOptions& r) { r.per_cell = 16; }, false},
    {"deterministic true", [](SceneOptions& r) { r.deterministic = true; }, false},
    {"a lattice's particles, not packed", [](SceneOptions& r) { r.packed = false; }, true},
};

// Default number of cells of a scene; fewer without a GPU.
int usual_cells(const Verification& v) { return FrontSizes{{16}, {32}, {64}}.of(v).front(); }

struct Bought {
    const Change* change;
    SceneOptions options;
    FrontResult result;
};

// Repeats all settings in turn, so that other load on the machine affects all equally; the fastest
// run of each counts.
std::vector<Bought> bought(const Verification& v, const FrontScene& scene)
{
    std::vector<Bought> all;
    const auto seeds = std::make_shared<Seeds>();
    for (const Change& change : changes) {
        if (v.quick() && !change.quick) continue;
        all.push_back({&change, default_options(usual_cells(v)), {}});
        all.back().options.watch = true, all.back().options.seeds = seeds;
        change.make(all.back().options);
    }
    for (int round = 0; round < (v.quick() ? 3 : 5); ++round)
        for (Bought& b : all) {
            if (interrupted()) return {};
            const FrontResult r = scene.run(b.options);
            const double before = round ? b.result.seconds : r.seconds;
            b.result = r;
            b.result.seconds = std::fmin(before, r.seconds);
        }
    return all;
}

}  // namespace

void feature_rows(Verification& v, const FrontScene& scene)
{
    const std::vector<Bought> all = bought(v, scene);
    for (const Bought& b : all) {
        const FrontResult &r = b.result, &usual = all.front().result;
        const std::string outcome =
            &b == &all.front()
                ? "default"
                : fmt::format("{:+.0f} % error, {:+.0f} % time", 100 * (r.error / usual.error - 1),
                              100 * (r.seconds / usual.seconds - 1));
        v.add(VerifyRow{"what a feature bought: " + scene.name,
                        b.change->name,
                        outcome,
                        {{"error_" + scene.unit, r.error},
                         {"seconds", r.seconds},
                         {"inside_mm", 1e3 * r.inside},
                         {"cells", double(b.options.cells)}}});
        if (v.options.json || v.options.quiet) continue;
        print(fmt::format(
            "    {} at {} cells/m, {:<34} {:>8.3f} {}  {:>8.4f} s  {:>5.2f} mm in tools  {}\n",
            scene.name, b.options.cells, b.change->name, r.error, scene.unit, r.seconds,
            1e3 * r.inside, outcome));
    }
}

}  // namespace knead
