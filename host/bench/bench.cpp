// knead bench: runs the selected suites on one device and writes the results.
#include "host/bench/bench.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/assets/mesh_object.h"
#include "host/assets/splat_object.h"
#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/outputs.h"
#include "host/base/parallel.h"
#include "host/base/paths.h"
#include "host/base/print.h"
#include "host/scene/seed.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

Device device_of(const std::string& text)
{
    const Device device = parse_device(text);
    if (device.kind == DeviceKind::cpu_double)
        throw UsageError("--device: expected auto, cuda, cuda:N or cpu: cpu:double is not timed");
    return resolved(device);
}

BenchOptions completed(BenchOptions o)
{
    std::vector<std::string> names;
    for (const auto& [name, suite] : suites()) names.push_back(name);
    o.suites = requested_names("suite", o.suites, names);
    if (o.case_limit <= 0) o.case_limit = o.quick ? 4 : 20;
    o.scene = file_or_shipped(o.scene);
    return o;
}

// The device's name as a folder name: lower case, "-" for all but letters and digits.
std::string folder_name(const std::string& device)
{
    std::string name;
    for (char c : device) {
        if (std::isalnum(static_cast<unsigned char>(c)))
            name += char(std::tolower(static_cast<unsigned char>(c)));
        else if (!name.empty() && name.back() != '-')
            name += '-';
    }
    while (!name.empty() && name.back() == '-') name.pop_back();
    return name.empty() ? "unknown" : name;
}

std::string folder_of(const Bench& bench)
{
    if (!bench.options.out.empty()) return bench.options.out;
    return (fs::path("profiling/results") / folder_name(bench.facts.name)).string();
}

// Runs a suite and returns its exit code. A failure is reported; the results of other suites are
// kept.
int attempted(Bench& bench, const std::string& name, Suite suite)
{
    std::string why;
    const int code = run_and_report([&] {
        try {
            suite(bench);
        } catch (const std::exception& e) {
            why = e.what();
            throw;
        }
        return int(exit_ok);
    });
    if (code) bench.result.left_out.push_back(name + ": " + why);
    bench.keep();  // also results that are not rows: targets, peers
    return code;
}

const std::vector<std::string> results{"bench.json", "bench.csv", "bench.part.json"};

std::string written(const Json& all)
{
    return all.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace

double gpu_clock()
{
    const std::optional<GpuState> state = gpu_state(gpu_bus());
    return state ? 1e6 * state->clock : 0;
}

Bench::Bench(const BenchOptions& o)
    : options(completed(o)),
      device(device_of(o.device)),
      facts(device_facts(device, o.threads)),
      figures(read_figures(figures_folder(o.data)))
{
}

Scene Bench::scene(const std::vector<std::string>& settings) const
{
    Scene s = read_scene(options.scene, settings);
    need_objects(s);
    s.setup.threads = options.threads;
    const std::size_t memory =
        options.max_memory > 0 ? std::size_t(options.max_memory * 0x1p20) : available_memory();
    load_meshes(s);
    load_splats(s, memory);
    build(s, memory);
    return s;
}

bool Bench::fits(const std::string& what, double particles, double host_bytes, double device_bytes)
{
    const auto refuse = [&](const char* side, double need, double there) {
        const std::string why =
            fmt::format("{}: {:.3g} particles need about {:.1f} GiB {}, {:.1f} GiB are free", what,
                        particles, need / 0x1p30, side, there / 0x1p30);
        say(why);
        result.left_out.push_back(why);
        return false;
    };
    const double host =
        options.max_memory > 0 ? options.max_memory * 0x1p20 : double(available_memory());
    if (particles * host_bytes > host) return refuse("of the host", particles * host_bytes, host);
    if (device.kind != DeviceKind::cuda) return true;
    const auto there = double(free_memory(device));
    return particles * device_bytes < there ||
           refuse("of the device", particles * device_bytes, there);
}

void Bench::add(BenchRow row)
{
    if (row.frames <= 0 && row.repeats <= 0) return;
    result.rows.push_back(std::move(row));
    keep();
}

void Bench::keep() const
{
    if (kept.empty()) return;
    Json all = bench_json(*this);
    all["left_out"].push_back("the rest: this was written before it was measured");
    try {
        write_whole(kept, written(all));
    } catch (const OutputError& e) {
        say(e.what());
    }
}

void Bench::say(const std::string& text) const
{
    if (!options.quiet) std::fprintf(stderr, "knead bench: %s\n", text.c_str());
}

bool Bench::stopped() const { return interrupted() != 0; }

std::vector<StageWork> Bench::counted(const std::function<std::vector<StageWork>()>& count)
{
    if (!options.count || uncountable || device.kind != DeviceKind::cuda) return {};
    try {
        return count();
    } catch (const std::runtime_error& e) {
        uncountable = true;
        say(e.what());
        result.left_out.push_back(e.what());
        return {};
    }
}

int bench_verb(const BenchOptions& options)
{
    set_loop_threads(options.threads);
    Bench bench(options);
    // Reports an invalid scene before any output is created.
    need_objects(read_scene(bench.options.scene, {}));
    const std::string folder = folder_of(bench);
    const FolderLock lock = prepare_folder(folder, results, options.overwrite);
    const auto in_folder = [&](const std::string& name) {
        return (fs::path(folder) / name).string();
    };
    bench.keep_in(in_folder("bench.part.json"));
    watch_interrupts();
    if (bench.device.kind != DeviceKind::cuda)
        bench.result.left_out.push_back(
            "instructions and bytes: only the counters of a GPU are read");
    else if (!options.count)
        bench.result.left_out.push_back("instructions and bytes: not asked for (--count)");
    bench.say(fmt::format("{}, copies {:.1f} GB/s", bench.facts.name, 1e-9 * bench.facts.copy));
    int failed = exit_ok;
    if (options.peers) failed = attempted(bench, "peers", run_peers);
    for (const auto& [name, suite] : suites()) {
        const auto& requested = bench.options.suites;
        if (bench.stopped() ||
            std::find(requested.begin(), requested.end(), name) == requested.end())
            continue;
        if (const int code = attempted(bench, name, suite)) failed = code;
    }
    if (bench.stopped()) bench.result.left_out.push_back("the rest: interrupted");
    const std::string json = written(bench_json(bench));
    write_whole(in_folder("bench.json"), json);
    write_whole(in_folder("bench.csv"), bench_csv(bench.result));
    std::error_code none_there;
    fs::remove(in_folder("bench.part.json"), none_there);
    if (const std::string why = draw(bench, in_folder("bench.json")); !why.empty()) {
        bench.say(why);
        bench.result.left_out.push_back(why);
    }
    print(options.json ? json : bench_text(bench));
    if (failed || bench.stopped())
        bench.say(std::string(failed ? "failed" : "interrupted") +
                  "; what was measured all the same is in " + folder);
    else
        bench.say("wrote " + folder);
    return bench.stopped() ? 128 + interrupted() : failed;
}

}  // namespace knead
