// stability: a map of stiff and extreme cases and their outcomes.
#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>

#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "host/scene/scene.h"
#include "host/verify/cases.h"

namespace knead {
namespace {

void add_row(Verification& v, const Case& c, const Outcome& o)
{
    v.add(VerifyRow{"stability map",
                    c.name,
                    fmt::format("{}: {}", ending_name(o.ending), o.note),
                    {{"substeps", double(o.stats.substeps)},
                     {"dt_min_us", 1e6 * o.stats.dt_min},
                     {"energy_gain", o.energy_gain},
                     {"volume", o.volume},
                     {"clipped", double(o.stats[Count::clipped])},
                     {"crowded_percent", 100 * o.crowded},
                     {"densest", o.densest},
                     {"seconds", o.seconds}}});
    v.say(
        fmt::format("{:<40} {}: {} ({:.1f} s)", c.name, ending_name(o.ending), o.note, o.seconds));
    if (o.ending != Ending::failed) return;
    Check check = at_most("map: " + c.name + ": failures", 1, 0, "", c.advice);
    check.note = o.note;
    v.add(check);
}

// Clay with one particle per cell fractures numerically under tension: scene files with it must be
// refused.
Outcome thin_scene()
{
    Outcome o;
    const std::string file =
        (std::filesystem::temp_directory_path() / fmt::format("knead-verify-{}.json", getpid()))
            .string();
    write_whole(file, R"({"schema": "knead.scene/1", "domain": {"edge": 1.0, "cells": 32},
        "objects": [{"centre": [0.5, 0.5, 0.5], "diameter": 0.3, "per_cell": 1}]})");
    try {
        read_scene(file);
        o.note = "was taken, and should have been refused";
    } catch (const InputError& e) {
        o.ending = Ending::refused, o.note = std::string(e.what()).substr(file.size() + 2);
    }
    std::filesystem::remove(file);
    return o;
}

}  // namespace

void map_part(Verification& v)
{
    int counts[5] = {}, all = 0;
    const auto report = [&](const Case& c, const Outcome& o) {
        ++counts[int(o.ending)], ++all;
        add_row(v, c, o);
    };
    outcomes_of(v, stability_cases(v.quick(), v.device.kind == DeviceKind::cuda), report);
    Case thin;
    thin.name = "a scene's file with 1 particle a cell";
    report(thin, thin_scene());
    Check c = at_least("map: cases that ended stable, guarded or refused",
                       double(counts[0] + counts[1] + counts[3]),
                       double(all - counts[int(Ending::failed)]), "",
                       v.quick() ? "the others ran out of time: run them without --quick"
                                 : "the others ran out of time: run them where nothing else runs");
    c.note = fmt::format("{} stable, {} guarded, {} slow, {} refused, {} failed", counts[0],
                         counts[1], counts[2], counts[3], counts[4]);
    v.add(c);
}

Case case_named(const Verification& v, const std::string& name)
{
    for (Case& c : stability_cases(v.quick(), v.device.kind == DeviceKind::cuda))
        if (c.name == name) return std::move(c);
    for (const Case& c : margin_cases(v.quick()))
        for (const double times : substep_ladder)
            if (Case longer = with_substep(c, times); longer.name == name) return longer;
    throw UsageError("--case: no case of the stability suite is named \"" + name.substr(0, 80) +
                     '"');
}

}  // namespace knead
