// knead verify: runs it, prints it, writes it; fails (1) where a check failed.
#include "host/verify/verify.h"

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/outputs.h"
#include "host/cli/verbs.h"
#include "host/verify/cases.h"

namespace knead {
namespace {

const std::vector<std::string> results{"verify.json", "verify.csv", "report.md"};

void write_results(const Verification& v)
{
    const std::filesystem::path folder(v.options.out);
    write_whole((folder / "verify.json").string(), verify_json(v).dump(2) + "\n");
    write_whole((folder / "verify.csv").string(), verify_csv(v));
    write_whole((folder / "report.md").string(), verify_page(v));
}

// What outcome_by() runs in a process of its own.
int tell_case(const Verification& v)
{
    const Case c = case_named(v, v.options.one);
    std::printf("%s\n", told(outcome_of(v, c, limit_of(c, v.quick()))).dump().c_str());
    return exit_ok;
}

}  // namespace

int verify_verb(VerifyOptions options)
{
    options.program = std::filesystem::read_symlink("/proc/self/exe").string();
    Verification v(options);
    if (!options.one.empty()) return tell_case(v);
    if (!options.out.empty()) prepare_folder(options.out, results, options.overwrite);
    watch_interrupts();
    run(v);
    if (!options.out.empty()) write_results(v);
    if (options.json)
        std::printf("%s\n", verify_json(v).dump(2).c_str());
    else
        std::fputs(verify_summary(v).c_str(), stdout);
    if (const int by = interrupted()) return by == 15 ? exit_terminate : exit_interrupt;
    const auto failed = [](const Check& c) { return c.verdict == Verdict::failed; };
    return std::any_of(v.checks.begin(), v.checks.end(), failed) ? exit_check : exit_ok;
}

}  // namespace knead
