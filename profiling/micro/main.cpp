// The small measurements that decide how particles reach the grid: see
// docs/engineering/microbenchmarks.md. Ends with 1 if any form computed something else than it
// should.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "host/base/machine.h"
#include "profiling/micro/table.h"

namespace {

using namespace knead;
using namespace knead::micro;

// What the results depend on, in a line.
std::string header(const Limits& limits)
{
    const nlohmann::json facts = machine_facts(true);
    const nlohmann::json gpu = facts.value("gpu", nlohmann::json::object());
    char clocks[160];
    std::snprintf(clocks, sizeof clocks,
                  "%.0f MHz measured under load (at most %u, memory %u), copy %.3f TB/s, "
                  "%.1f G vector atomics/s",
                  1e-6 * limits.clock, gpu.value("most_clock_MHz", 0u),
                  gpu.value("memory_clock_MHz", 0u), 1e-12 * limits.copy, 1e-9 * limits.adds);
    return "commit " + facts.value("commit", "") + ", " + facts.value("date", "") + ", " +
           gpu.value("name", "") + ", driver " + gpu.value("driver", "") + ", " + clocks;
}

}  // namespace

int main(int count, char** words)
{
    CLI::App app{"bench_micro: what a GPU takes for each way of doing one small thing"};
    Settings settings;
    std::string csv, json, table;
    app.add_option("--only", settings.only, "Only questions whose name holds this");
    app.add_option("--repeats", settings.repeats, "Timed runs of each form")
        ->check(CLI::Range(1, 1000));
    app.add_option("--once", settings.once,
                   "Run each form once, for a profiler, and write their names here");
    app.add_option("--instructions", table, "Table of instructions.py")->check(CLI::ExistingFile);
    app.add_option("--csv", csv, "Write the table here");
    app.add_option("--json", json, "Write the table here");
    CLI11_PARSE(app, count, words);
    try {
        const Instructions counted = table.empty() ? Instructions{} : instructions_from(table);
        Limits limits;
        const std::vector<Row> rows = measured(settings, limits);
        if (settings.once.empty()) print(rows, limits, counted);
        if (!csv.empty()) write_csv(csv, header(limits), rows, limits, counted);
        if (!json.empty()) write_json(json, machine_facts(true).dump(), rows, limits, counted);
        if (rows.empty()) {
            std::fprintf(stderr, "no question is named like \"%s\"\n", settings.only.c_str());
            return 2;
        }
        const auto wrong =
            std::count_if(rows.begin(), rows.end(), [](const Row& r) { return !r.right; });
        if (wrong) std::fprintf(stderr, "%ld forms computed something wrong\n", long(wrong));
        return wrong ? 1 : 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 4;
    }
}
