// knead verify: runs the selected suites, part by part.
#include "host/verify/verify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/json_reader.h"
#include "host/base/print.h"
#include "host/solver/reference.h"

namespace knead {
namespace {

std::vector<std::string> suite_names()
{
    std::vector<std::string> names;
    for (const VerifyPart& p : verify_parts())
        if (std::find(names.begin(), names.end(), p.suite) == names.end()) names.push_back(p.suite);
    return names;
}

VerifyOptions completed(VerifyOptions o)
{
    o.suites = requested_names("suite", o.suites, suite_names());
    return o;
}

bool wanted(const VerifyOptions& o, const VerifyPart& p)
{
    return std::find(o.suites.begin(), o.suites.end(), p.suite) != o.suites.end() &&
           std::string(p.name).find(o.only) != std::string::npos;
}

}  // namespace

const std::vector<VerifyPart>& verify_parts()
{
    // clang-format off
    static const std::vector<VerifyPart> parts{
        {"accuracy", "laws", laws_part},
        {"accuracy", "shear", shear_part},
        {"accuracy", "momentum", momentum_part},
        {"accuracy", "floor", floor_part},
        {"accuracy", "rolling", rolling_part},
        {"accuracy", "impact", impact_part},
        {"accuracy", "recovery", recovery_part},
        {"accuracy", "hands", hands_part},
        {"accuracy", "spheres", spheres_part},
        {"accuracy", "hertz", hertz_part},
        {"accuracy", "sand", sand_part},
        {"accuracy", "dam", dam_part},
        {"convergence", "patch", patch_part},
        {"convergence", "waves", waves_part},
        {"convergence", "twist", twist_part},
        {"convergence", "locking", locking_part},
        {"convergence", "cook", cook_part},
        {"convergence", "manufactured", manufactured_part},
        {"convergence", "squeeze", squeeze_part},
        {"workprecision", "front", front_part},
        {"stability", "margin", margin_part},
        {"stability", "steps", steps_part},
        {"stability", "map", map_part},
    };
    // clang-format on
    return parts;
}

Verification::Verification(const VerifyOptions& o)
    : options(completed(o)),
      device(resolved(parse_device(o.device == "reference" ? "cpu:double" : o.device))),
      known(read_known(o.data))
{
}

void Verification::add(Check check)
{
    const double now = wall_seconds();
    check.suite = suite;
    check.seconds = now - mark;
    mark = now;
    const auto reason = known.why.find(check.name);
    if (reason != known.why.end()) check.why = reason->second;
    if (!options.json && !options.quiet) print(verify_text(check));
    checks.push_back(std::move(check));
}

void Verification::say(const std::string& text) const
{
    if (!options.quiet) std::fprintf(stderr, "knead verify: %s\n", text.c_str());
}

std::unique_ptr<Simulator> Verification::solver(Setup setup) const
{
    setup.threads = options.threads;
    return make_solver(setup, device);
}

std::unique_ptr<Simulator> Verification::reference(Setup setup) const
{
    setup.threads = options.threads;
    return std::make_unique<Reference>(setup);
}

void run(Verification& v)
{
    if (!v.known.problem.empty()) v.say(v.known.problem);
    for (const VerifyPart& part : verify_parts()) {
        if (!wanted(v.options, part) || interrupted()) continue;
        v.suite = part.suite;
        v.lap();
        try {
            part.run(v);
        } catch (const std::exception& e) {
            if (interrupted()) break;  // an interrupt is no failure of the part
            Check c = at_most(std::string(part.name) + " runs to its end", std::nan(""), 0, "");
            c.note = e.what();
            v.add(std::move(c));
        }
    }
    if (v.checks.empty() && !interrupted())
        throw UsageError("--only: no part of these suites has \"" + v.options.only.substr(0, 60) +
                         "\" in its name");
}

}  // namespace knead
