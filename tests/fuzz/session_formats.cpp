// Scenes, and what comes of them: recorded hands, logs of commands, runs, reports, checkpoints, and
// the container of sessions.
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/assets/splat_object.h"
#include "host/base/json_reader.h"
#include "host/cli/compare.h"
#include "host/document/actions_file.h"
#include "host/files/chunk_file.h"
#include "host/hands/gesture.h"
#include "host/hands/recording.h"
#include "host/run/checkpoint.h"
#include "host/run/report.h"
#include "host/scene/foresight.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/session/backend.h"
#include "host/session/capture.h"
#include "host/session/session_file.h"
#include "tests/document/random.h"
#include "tests/files/chunk_bytes.h"
#include "tests/folder.h"
#include "tests/fuzz/formats.h"
#include "tests/run/checkpoint_6.h"
#include "tests/session/clay_rows.h"

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
"contact": {"grid": false, "passes": 1}, "step": {"courant": 0.5, "largest": 1e-3}})",
    R"({"schema": "knead.scene/1", "domain": {"edge": 1.0, "cells": 16},
"objects": [
 {"shape": "ellipsoid", "centre": [0.3, 0.3, 0.3], "size": [0.2, 0.2, 0.15]},
 {"shape": "rounded_box", "centre": [0.7, 0.3, 0.3], "size": [0.2, 0.2, 0.15], "rounding": 0.05},
 {"shape": "cone", "centre": [0.3, 0.3, 0.7], "diameter": 0.2, "height": 0.2},
 {"shape": "capsule", "centre": [0.7, 0.3, 0.7], "diameter": 0.1, "height": 0.2},
 {"shape": "torus", "centre": [0.5, 0.6, 0.5], "diameter": 0.4, "tube": 0.1}]})"};

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

// Of a salt that is the same on every run.
std::string chunk_seed(const std::vector<std::vector<Chunk>>& groups)
{
    const Folder folder;
    const std::string file = folder / "seed.knead";
    {
        ChunkWriter writer(file);
        for (const auto& group : groups) {
            for (const Chunk& chunk : group) writer.add(chunk);
            writer.commit();
        }
    }
    std::string bytes = read_text(file, 1 << 20);
    put_number(bytes, 24, 59);
    return rehashed(bytes);
}

Checkpoint small_checkpoint()
{
    SmallRun run = run_of(small_scenes[0]);
    Checkpoint c;
    c.meta = {"a-b-c", "0.1.0", "2026-01-01T00:00:00Z", "cpu", true, true};
    c.scene = {"a.json", small_scenes[0], {"seed=3"}};
    c.command = {{"scene", "a.json"}, {"frames", 5}, {"cpu_seconds", 0.5}};
    c.record = run.record, c.record.frames_wanted = 5;
    c.stored.state = run.state;
    c.stored.state.contents.particles.resize(40), c.stored.state.order.resize(40);
    c.stored.document = std::make_shared<const Document>(document_of(run.scene));
    c.stored.numbers.number[c.stored.document->objects[0]->id] = {0};
    c.stored.numbers.materials = run.scene.setup.materials;
    c.stored.ids_used = 1, c.stored.frames = long(c.record.rows.size()), c.stored.time = 0.5;
    return c;
}

// As written, and with payloads that a change of a byte does not spoil as a whole.
std::vector<std::string> checkpoint_seeds()
{
    const Folder folder;
    write_checkpoint(folder / "seed.knead", small_checkpoint());
    const ChunkFile file(folder / "seed.knead");
    std::vector<Chunk> as_written, plain;
    for (const ChunkHead& head : file.chunks()) {
        as_written.push_back(file.stored(head));
        const std::string payload = file.payload(head);
        plain.push_back({head.kind, head.flags & chunk_ancillary, head.id, head.parent,
                         payload.size(), payload});
    }
    return {chunk_seed({plain}), chunk_seed({as_written})};
}

// With right checksums, also of the states that are not compressed.
std::string summed_checkpoint(std::string bytes)
{
    for (const std::size_t at : chunk_places(bytes)) {
        const std::size_t payload = at + chunk_header_size, stored = number_in(bytes, at + 11, 5);
        if (number_in(bytes, at, 4) != state_kind.code || number_in(bytes, at + 4, 2) != 0 ||
            stored > bytes.size() - payload)
            continue;
        bytes.replace(payload, stored, summed(bytes.substr(payload, stored)));
    }
    return rehashed(bytes);
}

void read_a_checkpoint(const std::string& bytes)
{
    const Folder folder;
    const std::string file = folder / "checkpoint.knead";
    const auto read = [&](const std::string& as) {
        put_bytes(file, as);
        const Checkpoint c = read_checkpoint(file);
        must_pass("its own bytes", [&] {
            write_checkpoint(file, c);
            if (to_bytes(read_checkpoint(file).stored) != to_bytes(c.stored))
                throw std::logic_error("a checkpoint that reads as another");
        });
    };
    try {
        read(bytes);
    } catch (const InputError&) {
        read(summed_checkpoint(bytes));
    }
}

std::vector<std::string> older_checkpoint_seeds() { return {checkpoint_6(small_checkpoint())}; }
void read_an_older_checkpoint(const std::string& bytes)
{
    const Folder folder;
    const std::string file = folder / "checkpoint.knead";
    const auto read = [&](const std::string& as) {
        put_bytes(file, as);
        read_checkpoint(file);
    };
    try {
        read(bytes);
    } catch (const InputError&) {
        read(summed(bytes));
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

ClayRows fuzzed_rows()
{
    std::mt19937 random(1);
    return random_rows(random, 40, 3);
}
std::vector<std::string> capture_seeds()
{
    std::mt19937 random(2);
    const ClayRows a = fuzzed_rows();
    const Quantisation steps = coarse_steps();
    ClayRows plain;
    plain.count = 3000;
    plain.planes.assign(clay_planes * plain.count, 0.5f);
    plain.object.assign(plain.count, 1), plain.sides.assign(plain.count, 0);
    return {encoded(a),
            encoded({}),
            encoded(plain),
            difference(a, changed(random, a, 20)),
            difference(changed(random, a, 3), a),
            encoded(plain, &steps),
            difference(a, quantised(a, steps), &steps)};
}
// Whole rows, or a difference from fuzzed_rows(). Bytes of another hash than that of the rows that
// they lead to have been read to their end.
void read_a_capture(const std::string& input)
{
    std::string bytes = input;
    const auto complete = [](const auto& action) {
        try {
            action();
        } catch (const InputError& e) {
            if (!std::string_view(e.what()).ends_with("that it leads to") &&
                !std::string_view(e.what()).ends_with("that of its rows"))
                throw;
        }
    };
    const ClayRows a = fuzzed_rows();
    if (bytes.starts_with("clay")) {
        complete([&] {
            const ClayRows rows = decoded(bytes);
            must_pass("its own bytes", [&] { decoded(encoded(rows)); });
        });
        return;
    }
    // Made a difference from these rows.
    const std::uint64_t from = hash(a);
    if (bytes.size() >= 32) std::memcpy(bytes.data() + 24, &from, sizeof from);
    ClayRows rows = a;
    try {
        complete([&] {
            apply_difference(rows, bytes);
            const ClayRows other = rows;
            must_pass("back", [&] { apply_difference(rows, bytes); });
            must_pass("its own bytes", [&] { decoded(encoded(other)); });
        });
    } catch (const InputError&) {
        if (!same_rows(rows, a)) throw std::logic_error("refused, but the rows have changed");
        throw;
    }
    if (!same_rows(rows, a)) throw std::logic_error("back to other rows");
}
std::vector<std::string> chunk_seeds()
{
    const Chunk zeros = chunk_of("DATA", std::string(300000, '\0'), 1);
    const Chunk text = chunk_of("TEXT", R"({"some": "text"})", 2, 1, chunk_ancillary);
    Chunk newer = text;
    newer.flags |= 0x100, newer.id = 3;
    return {chunk_seed({}), chunk_seed({{zeros}, {text, zeros, text}}),
            chunk_seed({{chunk_of("NONE", "")}, {newer}})};
}

void read_all_chunks(const std::string& bytes)
{
    const Folder folder;
    const std::string file = folder / "fuzzed.knead";
    put_bytes(file, bytes);
    const ChunkFile read(file);
    read.verify();
    std::vector<Chunk> again;
    for (const ChunkHead& head : read.chunks()) {
        if (head.readable() && head.raw < memory) read.payload(head);
        again.push_back(read.stored(head));
    }
    if (again.empty()) return;
    must_pass("a copy and its chunks once more", [&] {
        const std::string copy = folder / "copy.knead";
        copy_chunks(file, read.end(), again, copy);
        if (ChunkFile(copy).chunks().size() != 2 * again.size())
            throw std::logic_error("a copy of other chunks");
    });
}
void read_chunks(const std::string& bytes)
{
    try {
        read_all_chunks(bytes);
    } catch (const InputError&) {
    }
    read_all_chunks(rehashed(bytes));
}

// A session of the first version: all of it, what a replay needs, the steps, and the least of one.
// Payloads are not compressed, so that changes are those of what they hold.
std::vector<std::string> session_seeds()
{
    const ChunkFile read("tests/golden/session_v1.knead");
    const auto seed = [&](std::string_view kinds) {
        std::vector<std::vector<Chunk>> groups(1);
        for (const ChunkHead& head : read.chunks()) {
            if (kinds.find(head.kind.text()) == std::string_view::npos) continue;
            std::string payload = read.payload(head);
            const std::uint64_t size = payload.size();
            if (groups.back().size() == 3) groups.emplace_back();
            groups.back().push_back(
                {head.kind, head.flags & ~chunk_compressed, head.id, head.parent, size, payload});
        }
        return chunk_seed(groups);
    };
    return {seed("META SCEN EVNT INPT STEP DIFF ROWS SPLT STAT THMB SAVD"), seed("META SCEN EVNT"),
            seed("META SCEN STEP DIFF ROWS STAT"), seed("META SCEN")};
}

void read_all_of_a_session(const std::string& bytes)
{
    const Folder folder;
    const std::string file = folder / "fuzzed.knead";
    put_bytes(file, bytes);
    const SessionFile session(file);
    EventWriter again;
    session.each_event([&](const SessionEvent& event) {
        again.add(event);
        return true;
    });
    must_pass("its own events", [&] { events_in(again.take(), "again.knead"); });
    session.hands();
    session.picture();
    History all;
    session.read_history(all, session.current());
    std::string refused;
    for (const StepInfo& step : all.list()) {
        try {
            all.rows_of(step.id);
        } catch (const InputError& e) {
            refused = e.what();
        }
    }
    for (const std::uint64_t id : session.states()) session.state(id);
    verify_session(session);
    if (!refused.empty()) throw std::logic_error("valid, but: " + refused);
    must_pass("a smaller one", [&] {
        const std::string smaller = folder / "smaller.knead";
        compact_session(session, smaller);
        verify_session(SessionFile(smaller));
    });
}
void read_a_session(const std::string& bytes)
{
    try {
        read_all_of_a_session(bytes);
    } catch (const InputError&) {
    }
    read_all_of_a_session(rehashed(bytes));
}

}  // namespace

std::vector<FuzzFormat> session_formats()
{
    return {{"scene", scene_seeds, read_a_scene},
            {"settings", setting_seeds, read_settings},
            {"run", run_seeds, run_a_scene},
            {"report", report_seeds, read_report},
            {"checkpoint", checkpoint_seeds, read_a_checkpoint},
            {"checkpoint-6", older_checkpoint_seeds, read_an_older_checkpoint},
            {"hands", hands_seeds, read_hands},
            {"hands-lines", hands_lines_seeds, read_hands},
            {"commands", command_seeds, read_commands},
            {"actions", action_seeds, read_older_actions},
            {"capture", capture_seeds, read_a_capture},
            {"chunks", chunk_seeds, read_chunks},
            {"session", session_seeds, read_a_session}};
}

}  // namespace knead
