// Options shared by several verbs, and those of the verbs that simulate.
#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

namespace knead {

using Verb = std::function<int()>;

// Accepts numbers from `low` to `high`, and no NaN as CLI::Range does.
CLI::Validator between(double low, double high);
// Accepts the form path.key=value; whether the scene has that key is checked later.
CLI::Validator setting();
// Throws InputError with a suggestion if the file does not exist and a bundled scene has a similar
// name. Other errors are reported when the file is read.
void check_scene(const std::string& name);
// `scene` if it is a session, else "". Throws UsageError for settings of a session.
std::string session_given(const std::string& scene, const std::vector<std::string>& settings,
                          int cells);
constexpr double longest_time = 1e9;  // [s]
constexpr double most_memory = 1e9;   // [MiB]

void add_run(CLI::App& app, Verb& chosen);
void add_record(CLI::App& app, Verb& chosen);
void add_vr(CLI::App& app, Verb& chosen);
void add_view(CLI::App& app, Verb& chosen);

}  // namespace knead
