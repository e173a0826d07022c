// knead run: simulates a scene with its hands, headless.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/assets/mesh_object.h"
#include "host/base/errors.h"
#include "host/base/interrupt.h"
#include "host/base/json_reader.h"
#include "host/base/machine.h"
#include "host/base/outputs.h"
#include "host/base/parallel.h"
#include "host/base/paths.h"
#include "host/base/print.h"
#include "host/cli/progress.h"
#include "host/cli/resume.h"
#include "host/cli/run_options.h"
#include "host/cli/script.h"
#include "host/cli/sequence.h"
#include "host/cli/verbs.h"
#include "host/files/mesh_file.h"
#include "host/files/particle_file.h"
#include "host/hands/recording.h"
#include "host/paging/scene_splats.h"
#include "host/picture/caption.h"
#include "host/picture/frame_writer.h"
#include "host/run/estimate.h"
#include "host/run/report.h"
#include "host/scene/domain.h"
#include "host/scene/foresight.h"
#include "host/scene/scene_hands.h"
#include "host/scene/seed.h"
#include "host/scene/soften.h"
#include "host/session/backend.h"
#include "host/session/scene_export.h"
#include "host/splats/deformed.h"

namespace knead {
namespace {
namespace fs = std::filesystem;

class Session {
  public:
    explicit Session(const RunOptions& options, const Checkpoint* from = nullptr,
                     FolderLock held = {})
        : o(options),
          earlier(from),
          lock(std::move(held)),
          scene(scene_of(o)),
          script(o, scene, [this](const std::string& text) { note(text); }),
          mesh_files(in_folder("meshes"), "mesh", o.mesh, o.mesh_every),
          clay_files(in_folder("particles"), "particles", "ply", o.particles_every)
    {
    }

    int run();

  private:
    std::string in_folder(const std::string& name) const
    {
        return (fs::path(o.out) / name).string();
    }
    bool has_splats() const { return splats->drawn().count() > 0; }
    void prepare();
    void clear();
    void open_writer();
    void keep_splats(RunObserver& watch, Simulator& solver, Device device);
    void keep_checkpoints(RunObserver& watch, const Simulator& solver, Device device);
    StoredState stored_state(const EditableSimulator& solver, const RunRecord& record) const;
    void watch(RunObserver& watch, Progress& progress, const Simulator& solver);
    void write(const RunRecord& record, const Simulator& solver);
    void write_cloud(const std::string& to, const Simulator& solver) const;
    void note(const std::string& text) const
    {
        if (!o.quiet) std::fprintf(stderr, "knead: %s\n", text.c_str());
    }
    void attempt(const std::string& name, const std::function<void(const std::string&)>& write);
    void add_to(Sequence& to, int frame, const std::function<void(const std::string&)>& write)
    {
        try {
            to.add(frame, write);
        } catch (const OutputError& e) {
            refused(e.what());
        }
    }
    void refused(const std::string& why)
    {
        std::fprintf(stderr, "knead: %s\n", why.c_str());
        output_refused = true;
    }
    int code(const RunRecord& record) const;

    const RunOptions& o;
    const Checkpoint* earlier;  // of the run to resume; null: a new run
    FolderLock lock;            // of o.out
    Scene scene;
    std::unique_ptr<SceneSplats> splats;
    std::unique_ptr<Simulator> simulator;
    RunScript script;  // its captures read the simulator: it ends first
    Sequence mesh_files, clay_files;
    BatchRunOptions run_options;
    RunInfo facts;
    std::vector<std::string> names{"report.json", "frames.csv"};  // files to be written
    double began = 0;  // start of the frame loop, wall_seconds() [s]
    // CPU time of the process at the start of the run, less the CPU time of the resumed run [s].
    double cpu_before = 0;
    std::unique_ptr<FrameWriter> writer;
    bool has_video = false, output_refused = false;
};

// Checks all input and output before the simulation starts.
void Session::prepare()
{
    const std::size_t memory =
        o.max_memory > 0 ? std::size_t(o.max_memory * 0x1p20) : available_memory();
    if (o.commands.empty()) need_objects(scene);
    check_substeps(scene);
    load_meshes(scene);
    const std::vector<SplatObject> objects = load_splats(scene, memory);
    for (const SplatObject& of : objects) {
        facts.splats += of.cloud.count(), facts.inside += of.cloud.count() - of.surface;
        const std::string& file = scene.objects[std::size_t(of.object)].splats.file;
        for (const std::string& remark : of.remarks) note(file + ": " + remark);
    }
    build(scene, memory);
    splats = std::make_unique<SceneSplats>(scene, objects);
    facts.local = splats->local();
    if (!o.out.empty()) {
        if (has_splats() && o.splats != "none") names.push_back("splats." + o.splats);
        if (o.mesh != "none") names.push_back("mesh." + o.mesh);
        if (o.particles) names.push_back("particles.ply");
        if (o.video) names.push_back("video.mp4");
        std::vector<std::string> places = names;
        if (scene.picture_every > 0) places.push_back("pictures/");
        if (mesh_files.wanted()) places.push_back("meshes/");
        if (clay_files.wanted()) places.push_back("particles/");
        std::error_code unknown;
        if (!lock.held() && fs::is_directory(o.out, unknown)) lock = FolderLock(o.out);
        const std::string left = in_folder(checkpoint_name);
        if (!earlier && !o.overwrite && fs::exists(left))
            throw OutputError(left +
                              ": is there already; --resume goes on with the run that it is of, "
                              "--overwrite replaces it");
        lock = prepare_folder(o.out, places, o.overwrite || earlier, std::move(lock));
    }
    run_options.frames = o.frames, run_options.time_limit = o.time_limit;
    run_options.meshes_every = o.mesh_every, run_options.particles_every = o.particles_every;
    run_options.whole_frames = script.any();
    run_options.last_mesh = !o.out.empty() && o.mesh != "none";
    facts.threads = o.threads, facts.settings = o.settings;
}

// Call after all checks: removes the partial files of a killed process, and with --overwrite the
// results of an earlier run, its report first, because it marks them as complete.
void Session::clear()
{
    if (o.out.empty()) return;
    remove_partials(o.out, [&](const std::string& name) {
        return name == checkpoint_name || name == ".knead-probe" ||
               std::find(names.begin(), names.end(), name) != names.end();
    });
    mesh_files.remove_partial(), clay_files.remove_partial();
    remove_partial_pictures(in_folder("pictures"));
    if (earlier || !o.overwrite) return;
    remove_files(o.out, names);
    remove_files(o.out, {checkpoint_name});
    remove_pictures(in_folder("pictures"));
    mesh_files.remove_old(), clay_files.remove_old();
}

// Commands would change the document and the numbers of its objects: their runs keep no
// checkpoints.
StoredState Session::stored_state(const EditableSimulator& solver, const RunRecord& record) const
{
    StoredState now;
    now.splats = splats->state(), now.local = splats->local_state();
    now.document = std::make_shared<const Document>(script.document());
    for (const auto& object : now.document->objects) {
        now.numbers.number[object->id] = script.simulated(object->id);
        now.ids_used = std::max(now.ids_used, object->id.value);
    }
    now.numbers.materials = solver.config().materials;
    now.frames = long(record.rows.size()),
    now.time = record.rows.empty() ? 0 : record.rows.back().hand_time;
    now.state = solver.save();
    return now;
}

// Checkpoints; write errors do not end the run.
void Session::keep_checkpoints(RunObserver& watch, const Simulator& solver, Device device)
{
    run_options.checkpoint = o.checkpoint.value_or(60);
    if (o.out.empty() || (o.checkpoint && *o.checkpoint == 0)) return;
    if (script.any()) {
        if (o.checkpoint || earlier)
            throw UsageError("--checkpoint, --resume: not where " + script.recorded_file() +
                             " is played");
        return;
    }
    if (is_standard(o.scene))
        return note("no checkpoints: a scene from standard input cannot be resumed");
    if (device.kind == DeviceKind::cpu_double) {
        if (o.checkpoint) throw UsageError("--checkpoint: not available with --device cpu:double");
        return;
    }
    const std::string name =
        device.kind == DeviceKind::cpu ? "cpu" : fmt::format("cuda:{}", device.index);
    SessionMeta meta = earlier ? earlier->meta : SessionMeta();
    if (meta.session.empty()) meta = new_session();
    meta.device = solver.name(), meta.stepped = true;
    meta.deterministic = device.kind == DeviceKind::cpu || scene.setup.deterministic;
    const SceneSource source{fs::absolute(o.scene).string(), read_text(o.scene, max_json_bytes),
                             settings_of(o)};
    watch.checkpoint = [this, &solver = *solver.editable(), name, meta,
                        source](const RunRecord& record) {
        const double begin = wall_seconds();
        try {
            const Json command = command_of(o, name, process_seconds() - cpu_before, scene);
            write_checkpoint(in_folder(checkpoint_name),
                             {meta, source, command, record, stored_state(solver, record)});
        } catch (const std::exception& e) {
            note(std::string("no checkpoint: ") + e.what());
        }
        // Without --checkpoint, checkpoints take at most a twentieth of the time.
        const double took = wall_seconds() - begin;
        if (!o.checkpoint) run_options.checkpoint = std::max(run_options.checkpoint, 20 * took);
    };
}

void Session::keep_splats(RunObserver& watch, Simulator& solver, Device device)
{
    if (!splats->changes()) return;
    if (device.kind == DeviceKind::cpu_double) {
        if (splats->local()) throw UsageError("--device cpu:double: local clay is not available");
        facts.left_out.push_back(
            "splats that are split or added: --device cpu:double does neither");
        return;
    }
    watch.upkeep = [this, &solver](const FrameResult& frame) {
        return splats->after(frame.number, frame.motion, *solver.editable());
    };
}

void Session::open_writer()
{
    if (scene.picture_every == 0) return;
    has_video = o.video && Video::available();
    if (o.video && !has_video) {
        facts.left_out.push_back("video: ffmpeg is not on the PATH");
        note(facts.left_out.back());
    }
    if (has_video && earlier)
        facts.left_out.push_back(fmt::format("video: the first {} frames, before the run went on",
                                             earlier->record.rows.size()));
    if (!scene.captions.empty() && !draws_text()) {
        facts.left_out.push_back("captions: this build has no Dear ImGui, which draws them");
        note(facts.left_out.back());
    }
    try {
        writer = std::make_unique<FrameWriter>(scene, in_folder("pictures"),
                                               has_video ? in_folder("video.mp4") : "",
                                               scene.frame_rate / scene.picture_every);
        const double limit = o.time_limit > 0 ? o.time_limit : 1e30;
        writer->give_up_when([=, this] { return interrupted() || wall_seconds() - began > limit; });
        run_options.mesh_every = scene.picture_every;
    } catch (const OutputError& e) {
        refused(e.what());
    } catch (const std::runtime_error& e) {
        note(e.what()), facts.left_out.push_back(std::string("pictures: ") + e.what());
    }
}

void Session::watch(RunObserver& watch, Progress& progress, const Simulator& solver)
{
    watch.frame = [&](const FrameRow& row) {
        if (o.verbose && !o.quiet) {
            progress.clear();
            note(fmt::format("frame {}: {} substeps, {:.3f} ms", row.frame, row.stats.substeps,
                             1e3 * row.wall));
        }
        progress.show(row.frame);
    };
    watch.on_progress = [&](int number, const FrameProgress& part) {
        progress.show(number - 1, part.reached / part.duration);
    };
    watch.meshes = [&](int number, const std::vector<Mesh>& all) {
        add_to(mesh_files, number, [&](const std::string& file) { write_mesh(file, all); });
    };
    watch.particles = [&](int number, const std::vector<Particle<double>>& all) {
        add_to(clay_files, number, [&](const std::string& file) { write_particles(file, all); });
    };
    watch.picture = [&](const FrameResult& frame, const std::vector<Mesh>& meshes) {
        if (!writer || interrupted()) return;
        splats->refresh();
        const bool coloured = std::ranges::any_of(
            script.document().objects, [](const auto& one) { return bool(one->colour); });
        const auto places = coloured ? script.places() : std::nullopt;
        try {
            writer->add(frame, meshes, splats->drawn(), solver.gaussians(), &script.document(),
                        places ? &*places : nullptr);
        } catch (const OutputError& e) {
            refused(e.what()), writer.reset();
        }
    };
}

// Writes one result; on a write error the others are still written.
void Session::attempt(const std::string& name, const std::function<void(const std::string&)>& write)
{
    try {
        write(in_folder(name));
        facts.outputs.push_back(in_folder(name));
    } catch (const std::runtime_error& e) {
        refused(e.what());
    }
}

void Session::write_cloud(const std::string& to, const Simulator& solver) const
{
    write_splats(to, splats_for_file(deformed(splats->drawn(), solver.gaussians()), scene.origin));
}

void Session::write(const RunRecord& record, const Simulator& solver)
{
    const bool files = !o.out.empty();
    splats->refresh();
    const bool failed = record.end == End::numerical_failure || record.end == End::device;
    if (files && o.mesh != "none" && record.meshes && !record.meshes->empty())
        attempt("mesh." + o.mesh, [&](const std::string& to) { write_mesh(to, *record.meshes); });
    if (files && (o.particles || failed))
        attempt("particles.ply",
                [&](const std::string& to) { write_particles(to, *record.last_good); });
    if (files && has_splats() && o.splats != "none" && !failed)
        attempt("splats." + o.splats, [&](const std::string& to) { write_cloud(to, solver); });
    if (writer && writer->count() > 0) {
        facts.outputs.push_back(in_folder("pictures"));
        if (has_video) attempt("video.mp4", [&](const std::string&) { writer->close(); });
    }
    for (const Sequence* sequence : {&mesh_files, &clay_files})
        if (sequence->count() > 0) facts.outputs.push_back(sequence->place());
    if (files)
        attempt("frames.csv", [&](const std::string& to) { write_whole(to, frames_csv(record)); });
    const auto text = [&] {
        return report(scene, record, facts).dump(2, ' ', false, Json::error_handler_t::replace) +
               "\n";
    };
    if (files) {
        facts.outputs.push_back(in_folder("report.json"));
        const std::string whole = text();
        facts.outputs.pop_back();
        attempt("report.json", [&](const std::string& to) { write_whole(to, whole); });
    }
    print(o.json ? text() : o.quiet ? "" : summary(report(scene, record, facts)));
}

int Session::code(const RunRecord& record) const
{
    if (!record.failure.empty()) std::fprintf(stderr, "knead: %s\n", record.failure.c_str());
    switch (record.end) {
        case End::interrupted:
            return 128 + interrupted();  // exit_interrupt, exit_terminate, exit_hangup
        case End::substeps:
        case End::refused:
            return exit_input;
        case End::numerical_failure:
            return exit_numbers;
        case End::device:
            return exit_device;
        case End::complete:
        case End::time_limit:
            break;
    }
    return output_refused ? exit_output : exit_ok;
}

int Session::run()
{
    const Device device = resolved(parse_device(o.device));
    prepare();
    std::unique_ptr<HandSource> hands;
    if (scene.has_hands) {
        const Recording recording = hands_of(scene);
        facts.hand_rate = recording.rate;
        facts.hand_latency = recording.latency;
        hands = std::make_unique<HandSource>(recording, scene.hands);
        script.add_recorded(scene, recording);
    }
    simulator = make_solver(scene.setup, device);
    const EditableSimulator* editable = simulator->editable();
    facts.solver = simulator->name();
    run_options.audit_every = o.audit_every > 0                 ? o.audit_every
                              : device.kind == DeviceKind::cuda ? 10
                                                                : 1;
    RunObserver watching;
    keep_splats(watching, *simulator, device);
    keep_checkpoints(watching, *simulator, device);
    if (earlier) load(*simulator->editable(), *earlier, scene, *splats, in_folder(checkpoint_name));
    clear();
    open_writer();
    const std::vector<std::string> rest = left_out(scene, run_options);
    facts.left_out.insert(facts.left_out.end(), rest.begin(), rest.end());
    const std::size_t gaussians = scene.setup.gaussians.size();
    scene.setup.particles = {}, scene.setup.gaussians = {};

    for (const Object& one : scene.objects)
        if (one.softer > 1) note(softened_text(scene, one));
    const Foresight steps = foresee(scene);
    note(fmt::format("a frame takes {:.6g} substeps of {:.3g} s, asked for by {}", steps.substeps,
                     steps.dt, steps.key));
    watch_interrupts();
    if (!o.quiet) note(cost_text(frame_cost(scene, device, gaussians)));
    RunRecord record;
    {
        Progress progress(frames_wanted(scene, hands.get(), o.frames), o.quiet || o.verbose);
        watch(watching, progress, *simulator);
        if (script.any())
            script.play(scene, *splats, *simulator, hands.get(),
                        frames_wanted(scene, hands.get(), o.frames), watching);
        cpu_before = process_seconds() - (earlier ? cpu_seconds_of(*earlier) : 0);
        began = wall_seconds();
        record = run_frames(scene, *simulator, hands.get(), run_options, watching,
                            earlier ? &earlier->record : nullptr);
        facts.cpu_seconds = process_seconds() - cpu_before;
    }
    if (script.left() > 0 && record.end == End::complete)
        note(fmt::format("commands after the last frame, not applied: {}", script.left()));
    if (scene.setup.rest.mode != RestMode::none)
        for (const std::string& spared : left_at_rest(record)) facts.left_out.push_back(spared);
    facts.history = script.history();
    if (!script.problem().empty()) refused(script.problem());
    facts.objects = object_facts(
        script.document(), [this](ObjectId object) { return script.simulated(object); },
        *record.last_good, editable ? editable->config().materials : scene.setup.materials);
    write(record, *simulator);
    const bool over = record.end == End::complete || record.end == End::numerical_failure;
    if (over && !o.out.empty() && !output_refused) remove_files(o.out, {checkpoint_name});
    return code(record);
}

}  // namespace

int run_verb(const RunOptions& options)
{
    check_options(options);
    set_loop_threads(options.threads);
    if (options.resume.empty()) return Session(options).run();
    std::error_code unknown;  // a missing folder is reported when the checkpoint is read
    FolderLock lock;
    if (fs::is_directory(options.resume, unknown)) lock = FolderLock(options.resume);
    const Checkpoint from = read_checkpoint((fs::path(options.resume) / checkpoint_name).string());
    const RunOptions given = options_of(from, options);
    return Session(given, &from, std::move(lock)).run();
}

}  // namespace knead
