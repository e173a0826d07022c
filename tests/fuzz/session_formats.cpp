// Scenes, and what comes of them: recorded hands, logs of commands, runs, reports, checkpoints.
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/assets/splat_object.h"
#include "host/base/json_reader.h"
#include "host/cli/compare.h"
#include "host/document/actions_file.h"
#include "host/hands/gesture.h"
#include "host/hands/recording.h"
#include "host/run/checkpoint.h"
#include "host/run/report.h"
#include "host/scene/foresight.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/session/backend.h"
#include "tests/document/random.h"
#include "tests/folder.h"
#include "tests/fuzz/formats.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t memory = 24u << 20;  // that a scene may take [bytes]

// Small enough to be run again and again.
const char* const small_scenes[] = {
    R"({"schema": "knead.scene/1", "name": "falls",  // and is squeezed
"domain": {"edge": 0.32, "cells": 16}, "gravity": [0, -9.81, 0], "frame_rate": 90,
"objects": [{"shape": "sphere", "centre": [0.16, 0.16, 0.16], "diameter": 0.1, "per_cell": 8,
             "velocity": [0, -1, 0], "material": {"preset": "clay", "young": 1e5}}],
"hands": {"recording": "squeeze", "zoom": 1.0}, "rest": {"mode": "sleep", "frames": 2},
"surface": {"nodes": 32}, "seed": 3})",
    R"({"schema": "knead.scene/1",
"domain": {"edge": 1.0, "cells": [16, 24, 8]},
"clock": "paper", "paper": {"substeps": 5, "dt": 1e-4},
"walls": {"min": [0.1, 0.1, 0.1], "max": [0.5, 0.8, 0.3]},
"objects": [
 {"name": "a", "shape": "box", "centre": [0.3, 0.3, 0.2], "size": [0.2, 0.2, 0.15],
  "material": "viscous-liquid", "category": 2},
 {"name": "b", "shape": "cylinder", "centre": [0.3, 0.6, 0.2], "diameter": 0.1, "height": 0.1,
  "material": {"preset": "snow", "density": 300}, "per_cell": 4.5}],
"contact": {"grid": false, "passes": 1}, "step": {"courant": 0.5, "largest": 1e-3}})"};

std::vector<std::string> scene_seeds()
{
    std::vector<std::string> all(std::begin(small_scenes), std::end(small_scenes));
    for (const auto& file : fs::directory_iterator("scenes"))
        if (file.path().extension() == ".json") all.push_back(read_text(file.path(), 1 << 20));
    std::sort(all.begin() + std::size(small_scenes), all.end());
    return all;
}

// What `info` and `run` ask of a scene before it moves.
Scene built(const std::string& text, const std::vector<std::string>& settings = {})
{
    Scene scene = parse_scene(text, "scenes/fuzzed.json", settings);
    foresee(scene);
    check_substeps(scene);
    load_splats(scene, memory);
    build(scene, memory);
    return scene;
}
void read_a_scene(const std::string& text)
{
    try {
        built(text);
    } catch (const MemoryError&) {
        // Most that come with the program are too large to be built here; they were read.
    }
}

// As `--set` has them: one a line.
std::vector<std::string> setting_seeds()
{
    return {"domain.cells=16\nobjects.0.material.bulk=1e5\nseed=5",
            "objects.1.material=dough\nobjects.1.material.density=900\npictures.every=2",
            "walls.min=[0.1,0.1,0.1]\nobjects.1.category=3\nrest={\"mode\":\"none\"}"};
}
void read_settings(const std::string& lines)
{
    std::vector<std::string> settings;
    for (std::size_t at = 0; at < lines.size() && settings.size() < 20;) {
        const std::size_t end = std::min(lines.find('\n', at), lines.size());
        settings.push_back(lines.substr(at, end - at));
        at = end + 1;
    }
    built(small_scenes[1], settings);
}

struct SmallRun {
    Scene scene;
    RunRecord record;
    SavedState state;
    std::string report;
};
// Two frames of ten substeps at most. Date and wall times are not today's: seeds are to be the same
// on every run.
SmallRun run_of(const std::string& text)
{
    SmallRun run;
    run.scene = parse_scene(text, "scenes/fuzzed.json");
    run.scene.most_substeps = 10, run.scene.setup.threads = 1;
    load_splats(run.scene, memory);
    build(run.scene, memory);
    std::unique_ptr<HandSource> hands;
    if (run.scene.has_hands)
        hands = std::make_unique<HandSource>(hands_of(run.scene), run.scene.hands);
    const std::unique_ptr<Simulator> solver = make_solver(run.scene.setup, {DeviceKind::cpu, 0});
    BatchRunOptions options;
    options.frames = 2, options.last_mesh = true;
    run.record = run_frames(run.scene, *solver, hands.get(), options, {});
    run.record.wall = 0.25;
    for (FrameRow& row : run.record.rows) {
        row.wall = 0.0625, row.hands_wall = 0.001, row.surface_wall = 0.0125;
        for (StageTime& stage : row.stages) stage.seconds = 0.0075;
    }
    run.state = solver->editable()->save();
    Json said = report(run.scene, run.record, {});
    said["context"]["date"] = "2026-01-01T00:00:00Z";
    run.report = said.dump();
    return run;
}

std::vector<std::string> run_seeds() { return {std::begin(small_scenes), std::end(small_scenes)}; }
void run_a_scene(const std::string& text)
{
    const SmallRun run = run_of(text);
    must_pass("its own report", [&] {
        const Json said = parse_json(run.report, "its report");
        check_report(said, "its report");
        summary(said);
    });
}

std::vector<std::string> report_seeds()
{
    return {run_of(small_scenes[0]).report, run_of(small_scenes[1]).report};
}
void read_report(const std::string& text)
{
    const Json said = parse_json(text, "report.json");
    static const Json other = parse_json(report_seeds()[0], "other.json");
    try {
        text_of(compared(other, said, {}));
    } catch (const InputError&) {
    }
    check_report(said, "report.json");
    summary(said);
}

// With the checksum of its other bytes in the last eight.
std::string summed(std::string bytes)
{
    if (bytes.size() < 8) return bytes;
    const std::uint64_t sum = XXH64(bytes.data(), bytes.size() - 8, 0);
    std::memcpy(bytes.data() + bytes.size() - 8, &sum, 8);
    return bytes;
}

std::vector<std::string> checkpoint_seeds()
{
    SmallRun run = run_of(small_scenes[0]);
    run.record.frames_wanted = 5;
    const Json command = {{"scene", "a.json"}, {"frames", 5}, {"cpu_seconds", 0.5}};
    run.state.contents.particles.resize(40), run.state.order.resize(40);
    const Folder folder;
    write_checkpoint(folder / "seed", {command, run.record, run.state, {}, {}});
    return {read_text(folder / "seed", 1 << 20)};
}
void read_a_checkpoint(const std::string& bytes)
{
    try {
        parse_checkpoint(bytes, "checkpoint.knead");
    } catch (const InputError&) {
        parse_checkpoint(summed(bytes), "checkpoint.knead");
    }
}

Recording short_hands()
{
    GestureOptions options;
    options.seconds = 0.1, options.dropouts = 0.2;
    return generate("squeeze", options);
}
std::vector<std::string> hands_seeds() { return {to_binary(short_hands())}; }
std::vector<std::string> hands_lines_seeds()
{
    Recording one = short_hands();
    one.frames.resize(1);
    return {to_lines(one), to_lines(short_hands())};
}
void read_hands(const std::string& bytes)
{
    const auto both_ways = [](const Recording& r) {
        must_pass("as binary", [&] { from_bytes(to_binary(r), "again.hands"); });
        must_pass("as lines", [&] { from_bytes(to_lines(r), "again.jsonl"); });
    };
    try {
        both_ways(from_bytes(bytes, "fuzzed.hands"));
    } catch (const InputError&) {
        both_ways(from_bytes(summed(bytes), "fuzzed.hands"));
    }
}

DocumentPtr applied(DocumentPtr document, const Command& command, IdSource& ids)
{
    const auto result = reduce(document, command, ids);
    if (const DocumentPtr* to = std::get_if<DocumentPtr>(&result)) {
        must_pass("its ids", [&] { with_ids(*document, command); });
        hash(**to);
        return *to;
    }
    return document;
}

// Each command of the table, in logs of their own and in one.
std::vector<std::string> command_seeds()
{
    Random r(1);
    IdSource ids;
    DocumentPtr room = empty_room();
    for (int i = 0; i < 4; ++i) {
        SceneObject o = random_object(r, {0, room.get()});
        o.id = {};
        room = applied(room, AddObject{o}, ids);
    }
    const Drawing by{0, room.get(), 0, true, true};
    std::vector<std::string> all;
    CommandLog whole{"scenes/ball.json", {"domain.cells=16"}, "0123", {}};
    for (std::size_t i = 0; i < command_rows.size(); ++i) {
        const LoggedCommand one{long(i / 2), random_command(r, by, i), 0};
        all.push_back(line_of(one));
        whole.commands.push_back(one);
    }
    all.push_back(to_text(whole));
    return all;
}

void read_commands(const std::string& text)
{
    const CommandLog log = parse_command_log(text, "log.jsonl", "/clay");
    const std::string again = to_text(log);
    must_pass("its own text", [&] {
        if (to_text(parse_command_log(again, "again.jsonl", "/clay")) != again)
            throw std::logic_error("a log that reads as another: " + again);
    });
    DocumentPtr document = empty_room();
    IdSource ids;
    for (const LoggedCommand& one : log.commands) document = applied(document, one.command, ids);
}

std::vector<std::string> action_seeds()
{
    return {R"({"schema": "knead.actions/1", "scene": "scenes/ball.json",
"settings": ["domain.cells=16"], "recording": "0123", "actions": [
{"time": 0, "do": "began", "by": "reset"}, {"time": 0.25, "do": "pause", "on": true},
{"time": 0.5, "do": "material", "object": 0, "material": {"elasticity": "neo-hookean",
 "plasticity": "von-mises", "density": 1800, "mu": 1e5, "lambda": 4e5, "bulk": 466666,
 "yield": 1000, "hardening": 0, "yield_floor": 0, "friction": 0, "cohesion": 0, "compress": 0,
 "stretch": 0, "snow": 0, "viscosity": 0, "exponent": 1}},
{"time": 1, "do": "gravity", "gravity": [0.1, -0.3, 2]},
{"time": 1, "do": "hands", "hands": {"zoom": 0.7, "at": [0, 2, -3],
 "left": {"present": true, "held": "knife"}, "right": {"present": false, "held": ""}}},
{"time": 1.5, "do": "move", "object": 0, "turn": [0, 0.6, 0], "turn_w": 0.8,
 "shift": [0.3, 0, 0]}]})"};
}

void read_older_actions(const std::string& text)
{
    const ActionsFile actions = parse_actions(text, "hands.actions", 90, {0.1, 0, 0});
    DocumentPtr document = empty_room();
    IdSource ids;
    SceneObject ball;
    ball.material = material_spec("clay"), ball.source.size = {0.1, 0.1, 0.1};
    ball.pose.p = {0.5, 0.5, 0.5};
    document = applied(document, AddObject{ball}, ids);
    for (const LogEntry& entry : actions.all)
        if (const Command* command = std::get_if<Command>(&entry.done))
            document = applied(document, *command, ids);
}

}  // namespace

std::vector<FuzzFormat> session_formats()
{
    return {{"scene", scene_seeds, read_a_scene},
            {"settings", setting_seeds, read_settings},
            {"run", run_seeds, run_a_scene},
            {"report", report_seeds, read_report},
            {"checkpoint", checkpoint_seeds, read_a_checkpoint},
            {"hands", hands_seeds, read_hands},
            {"hands-lines", hands_lines_seeds, read_hands},
            {"commands", command_seeds, read_commands},
            {"actions", action_seeds, read_older_actions}};
}

}  // namespace knead
