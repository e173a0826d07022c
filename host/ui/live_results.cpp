#include "host/ui/live_results.h"

#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/base/errors.h"
#include "host/base/paths.h"
#include "host/document/actions_file.h"
#include "host/files/mesh_file.h"
#include "host/hands/recording.h"
#include "host/run/report.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

constexpr const char* hands_name = "hands.hands";
constexpr const char* mesh_name = "mesh.glb";

// Writes the hands and the log of commands beside them. Removes those of an earlier recording, in
// either format, because they would be played with this one.
void write_hands(const std::string& file, LiveResults& results)
{
    const std::string log = command_log_of(file);
    std::vector<std::string> old{fs::path(actions_file(file)).filename().string()};
    if (results.commands.commands.empty()) old.push_back(fs::path(log).filename().string());
    const std::string folder = fs::path(file).parent_path().string();
    remove_files(folder.empty() ? "." : folder, old);
    write_recording(file, results.hands);
    if (results.commands.commands.empty()) return;
    results.commands.recording = file_hash(file);
    write_command_log(log, results.commands);
}

}  // namespace

FolderLock prepare(const LiveOutputs& o)
{
    if (!o.record.empty()) {
        const std::string form = ending(o.record);
        if (form != ".hands" && form != ".jsonl")
            throw UsageError("--record: expected a file ending in .hands or .jsonl, found \"" +
                             o.record + "\"");
        prepare_file(o.record, o.overwrite);
        prepare_file(command_log_of(o.record), o.overwrite);
        prepare_file(actions_file(o.record), o.overwrite);
    }
    if (o.out.empty()) return {};
    return prepare_folder(
        o.out,
        {o.report, mesh_name, hands_name, command_log_of(hands_name), actions_file(hands_name)},
        o.overwrite);
}

void add_simulation(nlohmann::json& report, const LiveResults& results, bool deterministic)
{
    const LiveState& s = *results.state;
    report["simulation"] = {{"solver", s.solver},
                            {"deterministic", deterministic},
                            {"frames", s.frame.number},
                            {"simulated_s", s.frame.simulated},
                            {"cut_frames", s.backlog.frames},
                            {"behind_s", s.backlog.missing_time},
                            {"trouble", s.failure},
                            {"state_hash", results.clay.hash},
                            {"particles", results.clay.particles},
                            {"splats", s.splats ? s.splats->count() : 0}};
    report["hands"] = {{"frames", results.hands.frames.size()},
                       {"actions", results.commands.commands.size()}};
}

bool write_results(const LiveOutputs& o, LiveResults& results, const nlohmann::json& report)
{
    bool all = true;
    const auto attempt = [&](const auto& write) {
        try {
            write();
        } catch (const std::runtime_error& e) {
            std::fprintf(stderr, "knead: %s\n", e.what());
            all = false;
        }
    };
    const auto in_folder = [&](const std::string& name) {
        return (fs::path(o.out) / name).string();
    };
    const bool hands = !results.hands.frames.empty();
    if (hands && !o.record.empty()) attempt([&] { write_hands(o.record, results); });
    if (o.out.empty()) return all;
    if (hands) attempt([&] { write_hands(in_folder(hands_name), results); });
    if (std::vector<Mesh> meshes = *meshes_of(*results.state); !meshes.empty())
        attempt([&] {
            if (results.state->scene) move_by(meshes, results.state->scene->scene.origin);
            write_mesh(in_folder(mesh_name), meshes);
        });
    attempt([&] { write_whole(in_folder(o.report), report.dump(2) + "\n"); });
    return all;
}

}  // namespace knead
