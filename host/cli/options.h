// What the options of several verbs share, and those of the verbs that simulate.
#pragma once
#include <CLI/CLI.hpp>
#include <functional>

namespace knead {

using Verb = std::function<int()>;

// A number from `low` to `high`. CLI::Range lets "nan" pass.
CLI::Validator between(double low, double high);
// path.key=value, before it is known whether a scene has that path.
CLI::Validator setting();
// Throws InputError where there is no such file, and a scene that comes with the program has nearly
// that name. Whoever reads the file says the rest.
void check_scene(const std::string& name);
constexpr double longest = 1e9;      // [s]
constexpr double most_memory = 1e9;  // [MiB]

void add_run(CLI::App& app, Verb& chosen);
void add_record(CLI::App& app, Verb& chosen);
void add_vr(CLI::App& app, Verb& chosen);
void add_view(CLI::App& app, Verb& chosen);

}  // namespace knead
