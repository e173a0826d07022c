// knead verify: runs the checks, prints and writes the results; exit code 1 if a check failed.
#include "host/verify/verify.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/outputs.h"
#include "host/base/parallel.h"
#include "host/base/print.h"
#include "host/bench/figures.h"
#include "host/cli/verbs.h"
#include "host/verify/cases.h"

namespace knead {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> result_files{"verify.json", "verify.csv", "report.md"},
    pictures{"workprecision.png", "convergence.png", "surface.png", "stability.png", "margins.png"};

// Draws the figures and returns those that exist.
std::vector<std::string> drawn(const Verification& v, const std::string& json)
{
    const fs::path folder(v.options.out);
    for (const std::string& name : pictures) fs::remove(folder / name);  // of an earlier run
    std::string said;
    const std::string problem =
        draw(figures_folder(v.options.data), "plot_verify.py", {json}, said);
    if (!problem.empty()) v.say(problem);
    std::vector<std::string> names;
    for (const std::string& name : pictures)
        if (fs::exists(folder / name)) names.push_back(name);
    return names;
}

void write_results(const Verification& v)
{
    const fs::path folder(v.options.out);
    const std::string json = (folder / "verify.json").string();
    write_whole(json, verify_json(v).dump(2) + "\n");
    write_whole((folder / "verify.csv").string(), verify_csv(v));
    write_whole((folder / "report.md").string(), verify_page(v, drawn(v, json)));
}

// Runs one case in a child process of outcome_by().
int tell_case(const Verification& v)
{
    const Case c = case_named(v, v.options.one);
    print(json_of(outcome_of(v, c, limit_of(v, c))).dump() + "\n");
    return exit_ok;
}

}  // namespace

int verify_verb(VerifyOptions options)
{
    // Children run this same executable even if its file was replaced.
    options.program = "/proc/self/exe";
    set_loop_threads(options.threads);
    Verification v(options);
    if (!options.one.empty()) return tell_case(v);
    FolderLock lock;
    if (!options.out.empty()) {
        std::vector<std::string> names = result_files;
        names.insert(names.end(), pictures.begin(), pictures.end());
        lock = prepare_folder(options.out, names, options.overwrite);
    }
    watch_interrupts();
    run(v);
    if (!options.out.empty()) write_results(v);
    print(options.json ? verify_json(v).dump(2) + "\n" : verify_summary(v));
    if (const int by = interrupted()) return 128 + by;
    const auto failed = [](const Check& c) { return c.verdict == Verdict::failed; };
    return std::any_of(v.checks.begin(), v.checks.end(), failed) ? exit_check : exit_ok;
}

}  // namespace knead
